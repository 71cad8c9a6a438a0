/* Whether values make sense together: ordered pairs, and a mass matrix that is positive definite at the present position. */

static int ordered(Instance *s) {
    for (int k = 0; k < fmu_orders; k++) {
        unsigned a = fmu_order[k][0], b = fmu_order[k][1];
        if (s->v[a] >= s->v[b]) continue;
        Message m = {{0}, 0};
        say(&m, fmu_name[a]); say(&m, " = "); say_number(&m, s->v[a]);
        say(&m, ": expected at least "); say(&m, fmu_name[b]); say(&m, " = "); say_number(&m, s->v[b]);
        refuse(s, &m);
        return 0;
    }
    return 1;
}

/* Append the parameters that the inertia of a joint depends on: those that were changed, else all; as many as the message holds. */
static void say_inertias(Instance *s, Message *m, int joint) {
    int changed = 0, said = 0;
    for (unsigned k = fmu_mass_first[joint]; k < fmu_mass_first[joint + 1]; k++) changed += s->v[fmu_mass[k]] != fmu_start[fmu_mass[k]];
    for (unsigned k = fmu_mass_first[joint]; k < fmu_mass_first[joint + 1]; k++) {
        unsigned vr = fmu_mass[k];
        if (changed && s->v[vr] == fmu_start[vr]) continue;
        if (m->n + 60 > sizeof m->text) { say(m, " and others"); return; }
        say(m, said++ ? ", " : " ");
        say(m, fmu_name[vr]); say(m, " = "); say_number(m, s->v[vr]);
    }
}

/* The first joint at which the mass matrix is not positive definite here, and its pivot there; -1 where there is none. */
static inline int weightless_joint(Instance *s, double *pivot) { return FMU_JOINTS ? kernel_pivot(s, pivot) : -1; }

/* Whether the mass matrix is positive definite here; else says at which joint it is not and which parameters make it. */
static int definite(Instance *s, Message *m) {
    double pivot = 0;
    const int joint = weightless_joint(s, &pivot);
    if (joint < 0) return 1;
    say(m, "mass matrix: expected to be positive definite, got the pivot "); say_number(m, pivot);
    say(m, " at joint "); say_number(m, fmu_joint[joint]);
    say(m, " at t = "); say_number(m, s->time); say(m, " s, from");
    say_inertias(s, m, joint);
    return 0;
}

APART static int check_values(Instance *s) {
    Message m = {{0}, 0};
    if (!ordered(s)) return 0;
    if (!definite(s, &m)) { refuse(s, &m); return 0; }
    s->unchecked = 0;
    return 1;
}

/* Whether values make sense together; they are looked at once after they have changed. */
static inline int consistent(Instance *s) { return !s->unchecked || check_values(s); }
