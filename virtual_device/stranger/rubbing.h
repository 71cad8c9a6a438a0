/* Dry friction of the stranger's joint after one of four laws, none of which is the LuGre law of friction.h.
 *
 * law 0, bristle:      s0 z + s1 z',  z' = v - s0 |v| / g(v) z,  g(v) = Fc + (Fs - Fc)/(1 + |v/vs|^sharpness)
 * law 1, Dahl:         F,             F' = s0 v |1 - sgn(v) F/Fc|^sharpness sgn(1 - sgn(v) F/Fc)     (Dahl 1968)
 * law 2, generalised Maxwell-slip: ELEMENTS springs of falling stiffness and uneven limits share_i g(v), with g as in
 *                      law 0; each sticks or slips, and slips by F_i' = sgn(v) attraction (share_i - |F_i|/g(v))
 * law 3, static:       g(v) tanh(v/creep), g(v) = Fc + (Fs - Fc)(1 - tanh(|v|/vs)): no state, no stick
 *
 * SI units, angles in rad.
 */
#ifndef RUBBING_H
#define RUBBING_H
#include <math.h>

#define RUBBING_PARAMETERS(X)                                                                                          \
  X(sigma0, 1.0) X(sigma1, 0) X(sigma2, 0) X(vs, 1.0) X(Fs, 1.0) X(Fc, 1.0) X(law, 0)                                  \
  X(sharpness, 2.0) X(attraction, 1.0) X(spread, 2.0) X(unevenness, 1.0) X(creep, 1.0)

enum { BRISTLE, DAHL, GENERALISED_MAXWELL, STATIC, ELEMENTS = 6 };

typedef struct {
#define X(name, value) double name;
  RUBBING_PARAMETERS(X)
#undef X
  double stiffness[ELEMENTS], share[ELEMENTS]; /* of the elements: share of s0, and of the level */
} Rubbing;

static double sign(double x) { return (x > 0) - (x < 0); }

/* g(v), the steady sliding friction. */
static double sliding_level(const Rubbing *r, double v) {
  if (r->law == DAHL) return r->Fc;
  if (r->law == STATIC) return r->Fc + (r->Fs - r->Fc) * (1 - tanh(fabs(v) / r->vs));
  return r->Fc + (r->Fs - r->Fc) / (1 + pow(fabs(v) / r->vs, r->sharpness));
}

/* Shares of a sum that fall by `ratio` from one element to the next. */
static void geometric_shares(double ratio, double *share) {
  double total = 0;
  for (int i = 0; i < ELEMENTS; i++) total += share[i] = pow(ratio, -i);
  for (int i = 0; i < ELEMENTS; i++) share[i] /= total;
}

/* Dry friction torque at a level, and the rates of its states. */
static double dry_rubbing(const Rubbing *r, double level, double v, const double *x, const double *slip, double *dx) {
  double sum = 0;
  if (r->law == STATIC) return level * tanh(v / r->creep);
  if (r->law == DAHL) {
    double left = 1 - sign(v) * x[0] / level;
    dx[0] = r->sigma0 * v * sign(left) * pow(fabs(left), r->sharpness);
    return x[0];
  }
  if (r->law == BRISTLE) {
    dx[0] = v - r->sigma0 * fabs(v) / level * x[0];
    return r->sigma0 * x[0] + r->sigma1 * dx[0];
  }
  for (int i = 0; i < ELEMENTS; i++) {
    double pull = r->attraction * (r->share[i] - fabs(x[i]) / level);
    dx[i] = slip[i] == 0 ? r->sigma0 * r->stiffness[i] * v : slip[i] * pull;
    sum += x[i];
  }
  return sum;
}

/* After a step: an element slips once its spring is at its limit, and sticks again when the speed has changed its sign. */
static void decide_slips(const Rubbing *r, double level, double v, double *x, double *slip) {
  if (r->law != GENERALISED_MAXWELL) return;
  for (int i = 0; i < ELEMENTS; i++) {
    double most = r->share[i] * level;
    if (slip[i] != 0 && v * slip[i] < 0) slip[i] = 0;
    if (slip[i] == 0 && x[i] * sign(v) > most) {
      slip[i] = sign(v);
      x[i] = slip[i] * most;
    }
  }
}

#endif
