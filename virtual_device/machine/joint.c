/* One locked joint with friction after one of the laws of friction.h, and everything that can disturb it.
 *
 *   Kp w = M(q) a + M'(q) v^2/2 + g_c cos q + g_s sin q + Ks (q - epos) + friction + (disturbing torques)
 *
 * Fixed-step classical Runge-Kutta between breaks: rows of the torque table, their delayed images, and sampling times.
 * All parameters but those of the undisturbed joint are neutral by default. SI units, angles in rad.
 */
#include <math.h>
#include <stddef.h>

#include "friction.h"

#define PARAMETERS(X)                                                                                                  \
  X(inertia, 1.0) X(gravity_cos, 0) X(gravity_sin, 0) X(Kp, 1.0) X(Ks, 0) X(epos, 0)                                   \
  FRICTION_PARAMETERS(X)                                                                                               \
  X(spring_quadratic, 0) X(spring_cubic, 0) X(payload_cos, 0) X(payload_sin, 0)                                        \
  X(inertia_linear, 0) X(inertia_quadratic, 0)                                                                         \
  X(coulomb_asymmetry, 0) X(viscous_asymmetry, 0)                                                                      \
  X(friction_wave, 0) X(friction_wave_number, 1.0) X(friction_wave_phase, 0) X(friction_slope, 0)                      \
  X(load_friction, 0) X(load_reference, 1.0) X(viscous_position, 0) X(stribeck_lag, 0) X(stribeck_change, 0)           \
  X(viscous_warmup, 0) X(viscous_warmup_time, 1.0) X(coulomb_warmup, 0) X(coulomb_warmup_time, 1.0)                    \
  X(drag, 0) X(hysteresis_stiffness, 0) X(hysteresis_travel, 1.0)                                                      \
  X(rotor_inertia, 0) X(tendon_stiffness, 0) X(tendon_damping, 0) X(tendon_slack, 0) X(encoder_play, 0)                \
  X(cogging, 0) X(cogging_number, 1.0) X(cogging_phase, 0) X(ripple, 0) X(ripple_number, 1.0) X(ripple_phase, 0)       \
  X(saturation_soft, 0) X(saturation_hard, 0) X(gain_cubic, 0) X(gain_reference, 1.0) X(dead_band, 0)                  \
  X(amplifier_lag, 0) X(delay, 0) X(gain_rate, 0) X(bias_rate, 0)                                                      \
  X(eccentricity, 0) X(eccentricity_phase, 0) X(encoder_ripple, 0) X(encoder_number, 1.0) X(encoder_phase, 0)          \
  X(clock_error, 0) X(stop_stiffness, 0) X(stop_damping, 0) X(stop_upper, 0) X(stop_lower, 0)                          \
  X(lock_inertia, 0) X(lock_coupling, 0) X(lock_stiffness, 0) X(lock_damping, 0)                                       \
  X(disturbance, 0) X(disturbance_frequency, 1.0) X(disturbance_phase, 0)                                              \
  X(patch_damping, 0) X(patch_centre, 0) X(patch_width, 1.0) X(detent, 0) X(detent_centre, 0) X(detent_width, 1.0)     \
  X(relaxation_stiffness, 0) X(relaxation_time, 1.0) X(heat_gain, 0) X(heat_reference, 1.0) X(heat_time, 1.0)          \
  X(sticky, 0) X(sticky_centre, 0) X(sticky_width, 1.0)

typedef struct {
#define X(name, value) double name;
  PARAMETERS(X)
#undef X
} Joint;

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

int joint_parameter_count(void) { return (int)(sizeof(Joint) / sizeof(double)); }
const char *joint_parameter_name(int i) { return NAMES[i]; }
double joint_parameter_default(int i) { return DEFAULTS[i]; }

enum { POSITION, VELOCITY, DRIVE, STRIBECK, SLIP, ROTOR, ROTOR_VELOCITY, LOCK, LOCK_VELOCITY, RELAXED, HEAT, FRICTION };
enum { NX = FRICTION + ELEMENTS };

static Friction friction_of(const Joint *j) {
  Friction f;
#define X(name, value) f.name = j->name;
  FRICTION_PARAMETERS(X)
#undef X
  return f;
}

static double bell(double x, double centre, double width) { return exp(-(x - centre) * (x - centre) / (width * width)); }

/* Torque that the amplifier is asked for, before its lag. */
static double amplifier(const Joint *j, double t, double command) {
  double w = command * (1 + j->gain_rate * t) + j->bias_rate * t;
  if (fabs(w) < j->dead_band) w = 0;
  if (j->gain_cubic != 0) w *= 1 + j->gain_cubic * (w / j->gain_reference) * (w / j->gain_reference);
  if (j->saturation_soft > 0) w = j->saturation_soft * tanh(w / j->saturation_soft);
  if (j->saturation_hard > 0) w = fmax(-j->saturation_hard, fmin(j->saturation_hard, w));
  return w;
}

/* g(v), the steady sliding friction, with what modulates it. */
static double modulated_level(const Joint *j, const Friction *f, double t, const double *x, double w) {
  double q = x[POSITION], v = x[VELOCITY], s = j->stribeck_lag > 0 ? x[STRIBECK] : v;
  double coulomb = j->Fc, scale = 1;
  if (j->stribeck_change != 0) s = j->vs * pow(fabs(s) / j->vs, 1 + 0.5 * j->stribeck_change); /* to the power 2 + change */
  if (j->coulomb_warmup != 0) coulomb *= 1 + j->coulomb_warmup * exp(-t / j->coulomb_warmup_time);
  if (j->coulomb_asymmetry != 0) scale *= 1 + j->coulomb_asymmetry * sign(v);
  if (j->friction_wave != 0) scale *= 1 + j->friction_wave * sin(j->friction_wave_number * q + j->friction_wave_phase);
  if (j->friction_slope != 0) scale *= 1 + j->friction_slope * q;
  if (j->load_friction != 0) scale *= 1 + j->load_friction * fabs(w) / j->load_reference;
  if (j->sticky != 0) scale *= 1 + j->sticky * bell(q, j->sticky_centre, j->sticky_width);
  return scale * friction_level(f, coulomb, s);
}

/* Dry friction torque, and the rates of its states. */
static double dry(const Joint *j, double t, const double *x, const double *slip, double w, double *dx) {
  Friction f = friction_of(j);
  return dry_friction(&f, modulated_level(j, &f, t, x, w), x[VELOCITY], &x[FRICTION], slip, &dx[FRICTION]);
}

static void decide(const Joint *j, double t, double *x, double *slip) {
  Friction f = friction_of(j);
  decide_slip(&f, modulated_level(j, &f, t, x, 0), x[VELOCITY], &x[FRICTION], slip);
}

static double viscous(const Joint *j, double t, double q, double v) {
  double d = j->sigma2 * (1 + j->viscous_asymmetry * sign(v)) + j->viscous_position * q * q + j->drag * fabs(v);
  if (j->viscous_warmup != 0) d += j->sigma2 * j->viscous_warmup * exp(-t / j->viscous_warmup_time);
  if (j->patch_damping != 0) d += j->patch_damping * bell(q, j->patch_centre, j->patch_width);
  return d * v;
}

static double stops(const Joint *j, double q, double v) {
  if (j->stop_stiffness == 0) return 0;
  if (q > j->stop_upper) return j->stop_stiffness * (q - j->stop_upper) + j->stop_damping * v;
  if (q < j->stop_lower) return j->stop_stiffness * (q - j->stop_lower) + j->stop_damping * v;
  return 0;
}

/* Torque held by position alone: gravity, springs, cogging, a detent. */
static double conservative(const Joint *j, double q) {
  double e = q - j->epos;
  double f = (j->gravity_cos + j->payload_cos) * cos(q) + (j->gravity_sin + j->payload_sin) * sin(q);
  f += j->Ks * e + j->spring_quadratic * e * e + j->spring_cubic * e * e * e;
  if (j->cogging != 0) f += j->cogging * sin(j->cogging_number * q + j->cogging_phase);
  if (j->detent != 0) f += j->detent * (q - j->detent_centre) / j->detent_width * bell(q, j->detent_centre, j->detent_width);
  return f;
}

double joint_static_torque(const double *p, double q) {
  const Joint *j = (const Joint *)p;
  return conservative(j, q) + stops(j, q, 0);
}

/* Torque that reaches the link: directly, or through a tendon that stretches and may hang slack. */
static double transmitted(const Joint *j, const double *x, double drive, double *dx) {
  double stretch = x[ROTOR] - x[POSITION], rate = x[ROTOR_VELOCITY] - x[VELOCITY], pull = 0;
  if (j->rotor_inertia <= 0) return drive;
  if (fabs(stretch) > j->tendon_slack)
    pull = j->tendon_stiffness * (stretch - sign(stretch) * j->tendon_slack) + j->tendon_damping * rate;
  dx[ROTOR] = x[ROTOR_VELOCITY];
  dx[ROTOR_VELOCITY] = (drive - pull) / j->rotor_inertia;
  return pull;
}

static void derivative(const Joint *j, double t, double command, const double *x, const double *slip, double *dx) {
  double q = x[POSITION], v = x[VELOCITY];
  double asked = amplifier(j, t, command), w = j->amplifier_lag > 0 ? x[DRIVE] : asked;
  for (int i = 0; i < NX; i++) dx[i] = 0;
  if (j->amplifier_lag > 0) dx[DRIVE] = (asked - w) / j->amplifier_lag;
  if (j->heat_gain != 0) {
    dx[HEAT] = ((w / j->heat_reference) * (w / j->heat_reference) - x[HEAT]) / j->heat_time;
    w *= 1 - j->heat_gain * x[HEAT];
  }
  if (j->ripple != 0) w *= 1 + j->ripple * sin(j->ripple_number * q + j->ripple_phase);
  if (j->stribeck_lag > 0) dx[STRIBECK] = (v - x[STRIBECK]) / j->stribeck_lag;
  double rubbing = dry(j, t, x, slip, w, dx);
  double force = transmitted(j, x, j->Kp * w, dx) - conservative(j, q) - viscous(j, t, q, v) - stops(j, q, v);
  force -= rubbing;
  if (j->hysteresis_stiffness != 0) {
    dx[SLIP] = v - fabs(v) * x[SLIP] / j->hysteresis_travel;
    force -= j->hysteresis_stiffness * x[SLIP];
  }
  if (j->relaxation_stiffness != 0) {
    dx[RELAXED] = v - x[RELAXED] / j->relaxation_time;
    force -= j->relaxation_stiffness * x[RELAXED];
  }
  if (j->disturbance != 0) force += j->disturbance * sin(j->disturbance_frequency * t + j->disturbance_phase);
  double M = j->inertia * (1 + j->inertia_linear * q + j->inertia_quadratic * q * q);
  force -= 0.5 * j->inertia * (j->inertia_linear + 2 * j->inertia_quadratic * q) * v * v;
  dx[POSITION] = v;
  if (j->lock_inertia > 0) { /* the neighbour: J p'' + c p' + k p = -m a, and the joint feels m p'' */
    double m = j->lock_coupling, J = j->lock_inertia;
    double held = -j->lock_stiffness * x[LOCK] - j->lock_damping * x[LOCK_VELOCITY], det = M * J - m * m;
    dx[LOCK] = x[LOCK_VELOCITY];
    dx[LOCK_VELOCITY] = (M * held - m * force) / det;
    dx[VELOCITY] = (J * force - m * held) / det;
  } else {
    dx[VELOCITY] = force / M;
  }
}

/* The largest rate [1/s] that does not depend on the state. */
static double fastest(const Joint *j) {
  double rate = (j->sigma1 + j->sigma2 + j->stop_damping + j->tendon_damping) / j->inertia;
  rate += sqrt((j->sigma0 + j->Ks + j->stop_stiffness + j->hysteresis_stiffness + j->tendon_stiffness) / j->inertia);
  if (j->rotor_inertia > 0) rate += sqrt(j->tendon_stiffness / j->rotor_inertia) + j->tendon_damping / j->rotor_inertia;
  if (j->lock_inertia > 0) rate += 2 * sqrt(j->lock_stiffness / j->lock_inertia) + j->lock_damping / j->lock_inertia;
  if (j->amplifier_lag > 0) rate += 0.2 / j->amplifier_lag;
  if (j->stribeck_lag > 0) rate += 0.2 / j->stribeck_lag;
  if (j->law == MAXWELL_SLIP) rate += j->C / fmin(j->Fc, j->Fs);
  return rate;
}

typedef struct {
  double t0, start, slope; /* command = start + slope (t - t0) */
} Line;

static void runge_kutta(const Joint *j, double t, double h, const Line *u, const double *slip, double *x) {
  double k1[NX], k2[NX], k3[NX], k4[NX], y[NX];
  double a = u->start + u->slope * (t - u->t0), b = a + 0.5 * h * u->slope, c = a + h * u->slope;
  derivative(j, t, a, x, slip, k1);
  for (int i = 0; i < NX; i++) y[i] = x[i] + 0.5 * h * k1[i];
  derivative(j, t + 0.5 * h, b, y, slip, k2);
  for (int i = 0; i < NX; i++) y[i] = x[i] + 0.5 * h * k2[i];
  derivative(j, t + 0.5 * h, b, y, slip, k3);
  for (int i = 0; i < NX; i++) y[i] = x[i] + h * k3[i];
  derivative(j, t + h, c, y, slip, k4);
  for (int i = 0; i < NX; i++) x[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
}

static double follow(const Joint *j, double play, double q) {
  double half = 0.5 * j->encoder_play;
  return fmin(fmax(play, q - half), q + half);
}

#define RUNAWAY 1e6 /* a speed [rad/s] from which on the motion counts as not finite */

static void advance(const Joint *j, double t, double end, const Line *u, double max_step, double *x, double *slip,
                    double *play) {
  double constant = fastest(j);
  while (end - t > 1e-12) {
    if (!(fabs(x[VELOCITY]) < RUNAWAY)) {
      x[POSITION] = NAN;
      return;
    }
    double weakest = j->law == DAHL ? j->Fc : fmin(j->Fc, j->Fs);
    double steepest = j->law == DAHL ? fmax(1, j->n) : 1;
    double rate = constant + 2 * steepest * j->sigma0 * fabs(x[VELOCITY]) / weakest;
    double h = fmin(max_step, 0.1 / rate);
    double left = ceil((end - t) / h - 1e-9);
    h = (end - t) / fmax(left, 1);
    runge_kutta(j, t, h, u, slip, x);
    t += h;
    decide(j, t, x, slip);
    *play = follow(j, *play, x[POSITION]);
  }
}

static double reading(const Joint *j, double q) {
  double y = q;
  if (j->eccentricity != 0) y += j->eccentricity * sin(q + j->eccentricity_phase);
  if (j->encoder_ripple != 0) y += j->encoder_ripple * sin(j->encoder_number * q + j->encoder_phase);
  return y;
}

static Line command(int n, const double *t, const double *u, int linear, double delay, int row) {
  Line line = {0, 0, 0};
  if (row < 0) return line; /* the delayed command has not arrived */
  line.t0 = t[row] + delay;
  line.start = u[row];
  if (linear && row + 1 < n) line.slope = (u[row + 1] - u[row]) / (t[row + 1] - t[row]);
  return line;
}

/* Simulate from x = (q0, v0, 0, ...). Writes position, velocity and encoder reading at the n sampling times.
 * Returns 0, or 1 + the row at which the state stopped being finite. */
int joint_simulate(const double *p, int n, const double *t, const double *torque, int linear, double q0, double v0,
                   double max_step, double *position, double *velocity, double *encoder) {
  const Joint *j = (const Joint *)p;
  double x[NX] = {0}, slip[ELEMENTS] = {0}, play = q0, now = t[0];
  int row = -1;
  x[POSITION] = x[ROTOR] = q0;
  x[VELOCITY] = x[ROTOR_VELOCITY] = x[STRIBECK] = v0;
  for (int k = 0; k < n; k++) {
    double sample = t[0] + (t[k] - t[0]) * (1 + j->clock_error);
    for (;;) {
      while (row + 1 < n && t[row + 1] + j->delay <= now + 1e-12) row++;
      if (sample - now <= 1e-12) break;
      Line u = command(n, t, torque, linear, j->delay, row);
      double end = row + 1 < n ? fmin(sample, t[row + 1] + j->delay) : sample;
      advance(j, now, end, &u, max_step, x, slip, &play);
      now = end;
    }
    if (!isfinite(x[POSITION])) return k + 1;
    position[k] = x[POSITION];
    velocity[k] = x[VELOCITY];
    encoder[k] = reading(j, j->encoder_play > 0 ? play : x[POSITION]);
  }
  return 0;
}
