/* One locked joint whose friction and disturbances follow other formulas than those of joint.c.
 *
 *   Kp w = M(q) a + M'(q) v^2/2 + g_c cos q + g_s sin q + Ks (q - epos) + friction + (disturbing torques)
 *
 * Friction is one of four laws (rubbing.h). Fixed-step classical Runge-Kutta between breaks: rows of the torque table, their
 * delayed images, and sampling times. Disturbances are absent by default. SI units, angles in rad.
 */
#include <math.h>

#include "rubbing.h"

#define PARAMETERS(X)                                                                                                  \
  X(inertia, 1.0) X(gravity_cos, 0) X(gravity_sin, 0) X(Kp, 1.0) X(Ks, 0) X(epos, 0)                                   \
  RUBBING_PARAMETERS(X)                                                                                                \
  X(spring, 0) X(spring_travel, 1.0) X(spring_power, 3.0) X(bend, 0) X(bend_width, 1.0)                                \
  X(stop, 0) X(stop_restitution, 0) X(stop_upper, 1e9) X(stop_lower, -1e9)                                             \
  X(limit, 0) X(limit_sharpness, 2.0) X(dead, 0) X(dead_sharpness, 2.0)                                                \
  X(gain, 0) X(gain_torque, 1.0) X(gain_power, 2.0) X(lag, 0) X(delay, 0)                                              \
  X(fading, 0) X(fading_time, 1.0) X(bias, 0) X(bias_time, 1.0) X(bias_power, 1.0)                                     \
  X(rotor_inertia, 0) X(tendon, 0) X(tendon_damping, 0) X(tendon_hysteresis, 0) X(tendon_travel, 1.0)                  \
  X(play, 0) X(play_change, 0) X(play_number, 1.0) X(play_phase, 0)                                                    \
  X(gear, 0) X(gear_number, 1.0) X(gear_phase, 0) X(gear_second, 0) X(gear_third, 0)                                   \
  X(gear_change, 0) X(gear_change_number, 1.0)                                                                         \
  X(ripple, 0) X(ripple_number, 1.0) X(ripple_phase, 0) X(ripple_steepness, 1.0)                                       \
  X(bump, 0) X(bump_centre, 0) X(bump_width, 1.0) X(load_drive, 0) X(load_back, 0) X(load_torque, 1.0)                 \
  X(warm, 0) X(warm_share, 1.0) X(warm_fast, 1.0) X(warm_slow, 1.0)                                                    \
  X(oil, 0) X(oil_share, 1.0) X(oil_fast, 1.0) X(oil_slow, 1.0)                                                        \
  X(drag, 0) X(drag_speed, 1.0) X(drag_power, 2.0) X(cosh_damping, 0) X(cosh_width, 1.0)                               \
  X(direction, 0) X(direction_speed, 1.0) X(damping_direction, 0) X(damping_direction_speed, 1.0)                      \
  X(stribeck_time, 0) X(cable, 0) X(cable_travel, 1.0) X(cable_power, 1.0) X(cable_share, 0.5)                         \
  X(swing, 0) X(swing_number, 1.0) X(swing_phase, 0)                                                                   \
  X(beat, 0) X(beat_frequency, 1.0) X(beat_phase, 0) X(beat_depth, 0) X(beat_slow, 1.0)                                \
  X(neighbour_inertia, 0) X(neighbour_coupling, 0) X(neighbour_stiffness, 0) X(neighbour_damping, 0)                   \
  X(neighbour_travel, 1.0)                                                                                             \
  X(eccentric, 0) X(eccentric_phase, 0) X(eccentric_second, 0) X(eccentric_second_phase, 0)                            \
  X(lines, 0) X(lines_number, 1.0) X(lines_phase, 0) X(clock, 0) X(clock_bend, 0) X(clock_time, 1.0)

typedef struct {
#define X(name, value) double name;
  PARAMETERS(X)
#undef X
} Stranger;

static const char *const NAMES[] = {
#define X(name, value) #name,
    PARAMETERS(X)
#undef X
};
static const double DEFAULTS[] = {
#define X(name, value) value,
    PARAMETERS(X)
#undef X
};

int stranger_parameter_count(void) { return (int)(sizeof(Stranger) / sizeof(double)); }
const char *stranger_parameter_name(int i) { return NAMES[i]; }
double stranger_parameter_default(int i) { return DEFAULTS[i]; }

enum { POSITION, VELOCITY, DRIVE, SEEN, SEEN_TWICE, CABLE, ROTOR, ROTOR_VELOCITY, TENDON, SIDE, SIDE_VELOCITY, RUBBING };
enum { NX = RUBBING + ELEMENTS };

static Rubbing rubbing_of(const Stranger *j) {
  Rubbing r;
#define X(name, value) r.name = j->name;
  RUBBING_PARAMETERS(X)
#undef X
  geometric_shares(j->spread, r.stiffness);
  geometric_shares(j->unevenness, r.share);
  return r;
}

/* sgn(x) |x|^p */
static double odd_power(double x, double p) { return x == 0 ? 0 : sign(x) * pow(fabs(x), p); }

/* Heat that is not yet there, from 1 to 0, by a fast and a slow time constant. */
static double cold(double t, double share, double fast, double slow) {
  return share * exp(-t / fast) + (1 - share) * exp(-t / slow);
}

/* Torque that the amplifier is asked for, before its lag. */
static double amplifier(const Stranger *j, double t, double command) {
  double w = command * (1 + j->fading * log(1 + t / j->fading_time));
  if (j->bias != 0) w += j->bias * pow(t / j->bias_time, j->bias_power);
  if (j->dead > 0) {
    double r = pow(fabs(w) / j->dead, j->dead_sharpness);
    w *= r / (1 + r);
  }
  if (j->gain != 0) w *= 1 + j->gain * pow(fabs(w) / j->gain_torque, j->gain_power);
  if (j->limit > 0) w /= pow(1 + pow(fabs(w) / j->limit, j->limit_sharpness), 1 / j->limit_sharpness);
  return w;
}

/* What multiplies the level of dry friction. */
static double friction_factor(const Stranger *j, double t, double q, double v, double w) {
  double scale = 1;
  if (j->warm != 0) scale *= 1 + j->warm * cold(t, j->warm_share, j->warm_fast, j->warm_slow);
  if (j->direction != 0) scale *= 1 + j->direction * tanh(v / j->direction_speed);
  if (j->bump != 0) scale *= 1 + j->bump / (1 + (q - j->bump_centre) * (q - j->bump_centre) / (j->bump_width * j->bump_width));
  if (j->load_drive != 0) scale *= 1 + (w * v > 0 ? j->load_drive : j->load_back) * fabs(w) / j->load_torque;
  return scale;
}

static double level(const Stranger *j, const Rubbing *r, double t, const double *x, double w) {
  double seen = j->stribeck_time > 0 ? x[SEEN_TWICE] : x[VELOCITY];
  return friction_factor(j, t, x[POSITION], x[VELOCITY], w) * sliding_level(r, seen);
}

static double viscous(const Stranger *j, double t, double q, double v) {
  double d = j->sigma2, f = 0;
  if (j->damping_direction != 0) d *= 1 + j->damping_direction * tanh(v / j->damping_direction_speed);
  if (j->oil != 0) d *= exp(j->oil * cold(t, j->oil_share, j->oil_fast, j->oil_slow));
  if (j->cosh_damping != 0) d += j->cosh_damping * (cosh(fmin(fabs(q - j->epos) / j->cosh_width, 20)) - 1);
  if (j->drag != 0) f = j->drag * odd_power(v / j->drag_speed, j->drag_power);
  return d * v + f;
}

/* Hunt and Crossley (1975): no pull while it lets go. */
static double contact(const Stranger *j, double depth, double rate) {
  return depth > 0 ? fmax(j->stop * pow(depth, 1.5) * (1 + j->stop_restitution * rate), 0) : 0;
}

static double stops(const Stranger *j, double q, double v) {
  return j->stop == 0 ? 0 : contact(j, q - j->stop_upper, v) - contact(j, j->stop_lower - q, -v);
}

static double gear(const Stranger *j, double q) {
  double a = j->gear_number * q + j->gear_phase, size = j->gear * (1 + j->gear_change * sin(j->gear_change_number * q));
  return size * (sin(a) + j->gear_second * sin(2 * a + 1) + j->gear_third * sin(3 * a + 2));
}

/* Torque held by position alone. */
static double conservative(const Stranger *j, double q) {
  double e = q - j->epos, f = j->gravity_cos * cos(q) + j->gravity_sin * sin(q) + j->Ks * e;
  if (j->spring != 0) f += j->spring * odd_power(e / j->spring_travel, j->spring_power);
  if (j->bend != 0) f += j->bend * (sqrt(e * e + j->bend_width * j->bend_width) - j->bend_width);
  if (j->gear != 0) f += gear(j, q);
  return f;
}

double stranger_static_torque(const double *p, double q) {
  const Stranger *j = (const Stranger *)p;
  return conservative(j, q) + stops(j, q, 0);
}

/* Rate of a hysteretic stretch z (Bouc, Wen): `share` of what holds it back turns its sign with the speed. */
static double bouc_wen(double z, double v, double travel, double power, double share) {
  return v - pow(fabs(z) / travel, power) * (share * fabs(v) * sign(z) + (1 - share) * v);
}

/* Torque that reaches the link: directly, or through a tendon with damping and a hysteresis of its own. */
static double transmitted(const Stranger *j, const double *x, double drive, double *dx) {
  double stretch = x[ROTOR] - x[POSITION], rate = x[ROTOR_VELOCITY] - x[VELOCITY], pull;
  if (j->rotor_inertia <= 0) return drive;
  pull = j->tendon * stretch + j->tendon_damping * rate + j->tendon_hysteresis * x[TENDON];
  dx[ROTOR] = x[ROTOR_VELOCITY];
  dx[ROTOR_VELOCITY] = (drive - pull) / j->rotor_inertia;
  dx[TENDON] = bouc_wen(x[TENDON], rate, j->tendon_travel, 1.0, 1.0);
  return pull;
}

/* Accelerations of the joint and, where there is one, of the neighbour on a spring that hardens. */
static void accelerate(const Stranger *j, const double *x, double M, double force, double *dx) {
  double m = j->neighbour_coupling, J = j->neighbour_inertia, p = x[SIDE] / j->neighbour_travel, held;
  if (J <= 0) {
    dx[VELOCITY] = force / M;
    return;
  }
  held = -j->neighbour_stiffness * x[SIDE] * (1 + p * p) - j->neighbour_damping * x[SIDE_VELOCITY];
  dx[SIDE] = x[SIDE_VELOCITY];
  dx[SIDE_VELOCITY] = (M * held - m * force) / (M * J - m * m);
  dx[VELOCITY] = (J * force - m * held) / (M * J - m * m);
}

static void derivative(const Stranger *j, const Rubbing *r, double t, double command, const double *x, const double *slip,
                       double *dx) {
  double q = x[POSITION], v = x[VELOCITY], asked = amplifier(j, t, command), w = j->lag > 0 ? x[DRIVE] : asked;
  for (int i = 0; i < NX; i++) dx[i] = 0;
  if (j->lag > 0) dx[DRIVE] = (asked - w) / j->lag;
  if (j->stribeck_time > 0) {
    dx[SEEN] = 2 * (v - x[SEEN]) / j->stribeck_time;
    dx[SEEN_TWICE] = 2 * (x[SEEN] - x[SEEN_TWICE]) / j->stribeck_time;
  }
  if (j->ripple != 0)
    w *= 1 + j->ripple * tanh(j->ripple_steepness * sin(j->ripple_number * q + j->ripple_phase)) / tanh(j->ripple_steepness);
  double rubbing = dry_rubbing(r, level(j, r, t, x, w), v, &x[RUBBING], slip, &dx[RUBBING]);
  double force = transmitted(j, x, j->Kp * w, dx) - conservative(j, q) - viscous(j, t, q, v) - stops(j, q, v) - rubbing;
  if (j->cable != 0) {
    dx[CABLE] = bouc_wen(x[CABLE], v, j->cable_travel, j->cable_power, j->cable_share);
    force -= j->cable * x[CABLE];
  }
  if (j->beat != 0)
    force += j->beat * (1 + j->beat_depth * sin(j->beat_slow * t)) * sin(j->beat_frequency * t + j->beat_phase);
  double angle = j->swing_number * q + j->swing_phase;
  force += 0.5 * j->inertia * j->swing * j->swing_number * sin(angle) * v * v;
  dx[POSITION] = v;
  accelerate(j, x, j->inertia * (1 + j->swing * cos(angle)), force, dx);
}

/* The largest rate [1/s] that does not depend on the state. */
static double fastest(const Stranger *j) {
  double M = j->inertia * (1 - fabs(j->swing)), rotor = j->rotor_inertia, side = j->neighbour_inertia;
  double tendon = j->tendon + j->tendon_hysteresis;
  double rate = (j->sigma1 + j->sigma2 * (1 + fabs(j->damping_direction)) * exp(fabs(j->oil)) + j->tendon_damping) / M;
  rate += sqrt((j->sigma0 + j->Ks + 2 * j->stop + j->cable + tendon) / M);
  if (j->law == STATIC) rate += 0.5 * j->Fs / (j->creep * M);
  if (j->law == GENERALISED_MAXWELL) rate += j->attraction / fmin(j->Fc, j->Fs);
  if (rotor > 0) rate += sqrt(tendon / rotor) + j->tendon_damping / rotor;
  if (side > 0) rate += 3 * sqrt(j->neighbour_stiffness / side) + j->neighbour_damping / side;
  if (j->lag > 0) rate += 0.2 / j->lag;
  if (j->stribeck_time > 0) rate += 0.4 / j->stribeck_time;
  return rate;
}

/* What the speeds of friction, cable and tendon add to it. */
static double changing(const Stranger *j, const double *x) {
  double v = fabs(x[VELOCITY]), rate = 2 * j->sigma0 * v / fmin(j->Fc, j->Fs);
  if (j->cable != 0) rate += 0.5 * v / j->cable_travel;
  if (j->rotor_inertia > 0) rate += 0.5 * fabs(x[ROTOR_VELOCITY] - x[VELOCITY]) / j->tendon_travel;
  return rate;
}

static void runge_kutta(const Stranger *j, const Rubbing *r, double t, double h, double command, const double *slip,
                        double *x) {
  static const double node[4] = {0, 0.5, 0.5, 1}, weight[4] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
  double k[4][NX], y[NX];
  for (int s = 0; s < 4; s++) {
    for (int i = 0; i < NX; i++) y[i] = x[i] + (s ? h * node[s] * k[s - 1][i] : 0);
    derivative(j, r, t + node[s] * h, command, y, slip, k[s]);
  }
  for (int i = 0; i < NX; i++)
    for (int s = 0; s < 4; s++) x[i] += h * weight[s] * k[s][i];
}

/* What an encoder behind play reads; the play is wider at some angles than at others. */
static double follow(const Stranger *j, double read, double q) {
  double half = 0.5 * j->play * (1 + j->play_change * sin(j->play_number * q + j->play_phase));
  return fmin(fmax(read, q - half), q + half);
}

#define RUNAWAY 1e6 /* a speed [rad/s] from which on the motion counts as not finite */

static void advance(const Stranger *j, const Rubbing *r, double t, double end, double command, double max_step, double *x,
                    double *slip, double *read) {
  double constant = fastest(j);
  while (end - t > 1e-12) {
    if (!(fabs(x[VELOCITY]) < RUNAWAY)) {
      x[POSITION] = NAN;
      return;
    }
    double h = fmin(max_step, 0.1 / (constant + changing(j, x)));
    h = (end - t) / fmax(ceil((end - t) / h - 1e-9), 1);
    runge_kutta(j, r, t, h, command, slip, x);
    t += h;
    decide_slips(r, level(j, r, t, x, 0), x[VELOCITY], &x[RUBBING], slip);
    *read = follow(j, *read, x[POSITION]);
  }
}

static double reading(const Stranger *j, double q) {
  double y = q + j->eccentric * sin(q + j->eccentric_phase);
  y += j->eccentric_second * sin(2 * q + j->eccentric_second_phase);
  if (j->lines != 0) y += j->lines * 0.63661977236758134 * asin(sin(j->lines_number * q + j->lines_phase));
  return y;
}

/* Simulate from rest at q0, the torque held between rows. Writes position, velocity and encoder reading at the n sampling
 * times. Returns 0, or 1 + the row at which the state stopped being finite. */
int stranger_simulate(const double *p, int n, const double *t, const double *torque, double q0, double max_step,
                      double *position, double *velocity, double *encoder) {
  const Stranger *j = (const Stranger *)p;
  double x[NX] = {0}, slip[ELEMENTS] = {0}, read = q0, now = t[0];
  int row = -1;
  Rubbing r = rubbing_of(j);
  x[POSITION] = x[ROTOR] = q0;
  for (int k = 0; k < n; k++) {
    double since = t[k] - t[0], sample = t[0] + since * (1 + j->clock + j->clock_bend * since / j->clock_time);
    for (;;) {
      while (row + 1 < n && t[row + 1] + j->delay <= now + 1e-12) row++;
      if (sample - now <= 1e-12) break;
      double end = row + 1 < n ? fmin(sample, t[row + 1] + j->delay) : sample;
      advance(j, &r, now, end, row < 0 ? 0 : torque[row], max_step, x, slip, &read);
      now = end;
    }
    if (!isfinite(x[POSITION])) return k + 1;
    position[k] = x[POSITION];
    velocity[k] = x[VELOCITY];
    encoder[k] = reading(j, j->play > 0 ? read : x[POSITION]);
  }
  return 0;
}
