/* Friction of one joint after one of three laws; a joint alone (joint.c) and each joint of the arm (arm.c) have it.
 *
 * law 0, LuGre:        friction = s0 z + s1 z' + s2 v,  z' = v - s0 |v| / g(v) z,  g(v) = Fc + (Fs - Fc) exp(-(v/vs)^2)
 * law 1, Dahl:         friction = s0 z + s2 v,          z' = v sgn(r) |r|^n,  r = 1 - s0 z sgn(v) / Fc
 * law 2, Maxwell-slip: friction = sum F_i + s2 v over ELEMENTS springs that each stick or slip (Al-Bender, Lampaert,
 *                      Swevers 2005): F_i' = k_i v until |F_i| = a_i g(v), then F_i' = sgn(v) C (a_i - |F_i|/g(v)) until the
 *                      speed changes its sign. From one element to the next k_i falls by the factor `spread`, a_i by the
 *                      factor `unevenness`; their sums are s0 and 1.
 *
 * What is here is the dry friction, without s2 v. SI units, angles in rad.
 */
#ifndef FRICTION_H
#define FRICTION_H
#include <math.h>

#define FRICTION_PARAMETERS(X)                                                                                         \
  X(sigma0, 1.0) X(sigma1, 0) X(sigma2, 0) X(vs, 1.0) X(Fs, 1.0) X(Fc, 1.0) X(law, 0) X(C, 1.0) X(spread, 2.0)    \
  X(unevenness, 1.0) X(n, 1.0)

typedef struct {
#define X(name, value) double name;
  FRICTION_PARAMETERS(X)
#undef X
} Friction;

/* A joint has room for one state per element: the bristle z of LuGre and Dahl is the first, and the others stay 0.
 * Beside them stands the direction in which each element slips, 0 while it sticks; it is fixed within a step. */
enum { LUGRE, DAHL, MAXWELL_SLIP, ELEMENTS = 6 };

static double sign(double x) { return (x > 0) - (x < 0); }

/* g(v), the steady sliding friction, for a Coulomb friction and a speed that may be other than the joint's own. */
static double friction_level(const Friction *f, double coulomb, double v) {
  if (f->law == DAHL) return coulomb;
  return coulomb + (f->Fs - coulomb) * exp(-(v / f->vs) * (v / f->vs));
}

/* Shares of the elements in a sum that falls by `ratio` from one element to the next. */
static void falling_shares(double ratio, double *share) {
  double total = 0;
  for (int i = 0; i < ELEMENTS; i++) total += share[i] = pow(ratio, -i);
  for (int i = 0; i < ELEMENTS; i++) share[i] /= total;
}

/* Dry friction torque at a level, and the rates of all states. */
static double dry_friction(const Friction *f, double level, double v, const double *x, const double *slip, double *dx) {
  double sum = 0;
  for (int i = 0; i < ELEMENTS; i++) dx[i] = 0;
  if (f->law == MAXWELL_SLIP) {
    double stiffness[ELEMENTS], limit[ELEMENTS];
    falling_shares(f->spread, stiffness);
    falling_shares(f->unevenness, limit);
    for (int i = 0; i < ELEMENTS; i++) {
      dx[i] = slip[i] == 0 ? f->sigma0 * stiffness[i] * v : slip[i] * f->C * (limit[i] - fabs(x[i]) / level);
      sum += x[i];
    }
    return sum;
  }
  if (f->law == DAHL) {
    double left = 1 - f->sigma0 * x[0] * sign(v) / level;
    dx[0] = v * sign(left) * pow(fabs(left), f->n);
    return f->sigma0 * x[0];
  }
  dx[0] = v - f->sigma0 * fabs(v) / level * x[0];
  return f->sigma0 * x[0] + f->sigma1 * dx[0];
}

/* After a step: an element slips once its spring is at the limit, and sticks again when the speed has changed its sign. */
static void decide_slip(const Friction *f, double level, double v, double *x, double *slip) {
  if (f->law != MAXWELL_SLIP) return;
  double share[ELEMENTS];
  falling_shares(f->unevenness, share);
  for (int i = 0; i < ELEMENTS; i++) {
    if (slip[i] != 0 && v * slip[i] < 0) slip[i] = 0;
    double limit = level * share[i];
    if (slip[i] == 0 && x[i] * sign(v) > limit) {
      slip[i] = sign(v);
      x[i] = slip[i] * limit;
    }
  }
}

#endif
