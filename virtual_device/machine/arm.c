/* A six-joint arm of the Freedom 6S kind: waist, upper arm, parallelogram rod, forearm, three-axis wrist with handle.
 *
 * Six frames turn one on another; every centroid is a sum of pieces, each carried rigidly by one frame, from the
 * shoulder outward. A piece r in a frame of angular velocity w has velocity w x r and, at zero joint acceleration,
 * acceleration alpha x r + w x (w x r). Kane's equations with these velocities give
 *
 *   M a + h = tau,   M = sum m Jv'Jv + Jw' I Jw,   h = sum m Jv'(a0 - g) + Jw'(I alpha + w x I w),
 *
 * to which each joint adds its spring, and friction after its own law of friction.h. Base X right, Y away from the user,
 * Z up. SI units.
 */
#include <math.h>
#include <string.h>

#include "friction.h"

/* The state x is q (6,), v (6,), and the friction states of each joint (6, ELEMENTS); NS of them are integrated. Behind
 * them stands where the elements slip (6, ELEMENTS). */
enum { NQ = 6, NF = 6, NL = 7, INNER = 2 * NQ, NS = INNER + NQ * ELEMENTS, NX = NS + NQ * ELEMENTS };

typedef struct {
  double mass, centroid[3], inertia[6]; /* xx yy zz xy xz yz about the centroid, axes of the link */
} Link;

typedef struct {
  double Kp, Ks, epos;
  Friction friction;
} Drive;

/* What may be hidden in a joint: torques of position and speed, and a gain that falls with the torque squared. */
typedef struct {
  double cubic, cog, cog_number, cog_phase, drag_up, drag_down, drag_square, gain_fall;
} Hidden;

typedef struct {
  double upper, forearm, crank, handle, gravity;
  Link link[NL];
  Drive drive[NQ];
} Arm;

int arm_parameter_count(void) { return (int)(sizeof(Arm) / sizeof(double)); }
int arm_state_count(void) { return NX; }

/* Frame f turns about its own axis AXIS[f] by joint JOINT[f], on the frame before it. */
static const int JOINT[NF] = {0, 1, 2, 3, 5, 4}, AXIS[NF] = {2, 0, 0, 2, 0, 1};
enum { WAIST, UPPER, FORE, YAW, PITCH, ROLL };
static const int CARRIER[NL] = {WAIST, UPPER, UPPER, FORE, YAW, PITCH, ROLL}; /* link 3, the rod, keeps link 2's orientation */

typedef struct {
  double R[3][3], axis[3], omega[3], alpha[3];
} Frame;

static void cross(const double *a, const double *b, double *c) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}
static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static void rotate(const double R[3][3], const double *a, double *b) {
  for (int i = 0; i < 3; i++) b[i] = dot(R[i], a);
}

static void frames(const double *q, const double *v, Frame *F) {
  static const Frame ground = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0}, {0}, {0}};
  const Frame *P = &ground;
  for (int f = 0; f < NF; P = &F[f++]) {
    double c = cos(q[JOINT[f]]), s = sin(q[JOINT[f]]), w[3], a[3];
    int k = AXIS[f], i = (k + 1) % 3, j = (k + 2) % 3;
    for (int r = 0; r < 3; r++) {
      F[f].R[r][k] = F[f].axis[r] = P->R[r][k];
      F[f].R[r][i] = c * P->R[r][i] + s * P->R[r][j];
      F[f].R[r][j] = c * P->R[r][j] - s * P->R[r][i];
      w[r] = F[f].axis[r] * v[JOINT[f]];
      F[f].omega[r] = P->omega[r] + w[r];
    }
    cross(P->omega, w, a);
    for (int r = 0; r < 3; r++) F[f].alpha[r] = P->alpha[r] + a[r];
  }
}

typedef struct {
  double r[3], a[3], J[3][NQ]; /* position, acceleration at zero joint acceleration, velocity per joint rate */
} Point;

static void add_piece(const Frame *F, int f, double x, double y, double z, Point *p) {
  double local[3] = {x, y, z}, r[3], c[3], d[3];
  rotate(F[f].R, local, r);
  cross(F[f].omega, r, c);
  cross(F[f].omega, c, d);
  cross(F[f].alpha, r, c);
  for (int i = 0; i < 3; i++) p->r[i] += r[i], p->a[i] += c[i] + d[i];
  for (int g = 0; g <= f; g++) {
    cross(F[g].axis, r, c);
    for (int i = 0; i < 3; i++) p->J[i][JOINT[g]] += c[i];
  }
}

static void origin(const Arm *arm, const Frame *F, int link, Point *p) {
  memset(p, 0, sizeof *p);
  if (link == 2) add_piece(F, FORE, 0, arm->crank, 0, p); /* the rod's pin, on the crank parallel to the forearm */
  if (link >= 3) add_piece(F, UPPER, 0, 0, arm->upper, p);
  if (link >= 4) add_piece(F, FORE, 0, -arm->forearm, 0, p);
}

/* Inertia about the centroid times a world vector: R I R' w. */
static void turn(const Link *l, const Frame *F, const double *w, double *out) {
  double b[3] = {0}, c[3];
  const double *I = l->inertia;
  for (int i = 0; i < 3; i++)
    for (int r = 0; r < 3; r++) b[i] += F->R[r][i] * w[r];
  c[0] = I[0] * b[0] + I[3] * b[1] + I[4] * b[2];
  c[1] = I[3] * b[0] + I[1] * b[1] + I[5] * b[2];
  c[2] = I[4] * b[0] + I[5] * b[1] + I[2] * b[2];
  rotate(F->R, c, out);
}

static void add_link(const Arm *arm, const Frame *F, int n, double M[NQ][NQ], double *h) {
  const Link *l = &arm->link[n];
  const Frame *B = &F[CARRIER[n]];
  double spin[3], torque[3], part[3], Iw[NQ][3];
  Point p;
  origin(arm, F, n, &p);
  add_piece(F, CARRIER[n], l->centroid[0], l->centroid[1], l->centroid[2], &p);
  p.a[2] += arm->gravity;
  turn(l, B, B->omega, spin);
  cross(B->omega, spin, torque);
  turn(l, B, B->alpha, part);
  for (int i = 0; i < 3; i++) torque[i] += part[i];
  for (int g = 0; g < NF; g++) {
    int j = JOINT[g], turns = g <= CARRIER[n];
    for (int i = 0; i < 3; i++) h[j] += l->mass * p.J[i][j] * p.a[i];
    if (turns) h[j] += dot(F[g].axis, torque), turn(l, B, F[g].axis, Iw[g]);
  }
  for (int a = 0; a < NF; a++)
    for (int b = 0; b < NF; b++) {
      int i = JOINT[a], j = JOINT[b];
      for (int k = 0; k < 3; k++) M[i][j] += l->mass * p.J[k][i] * p.J[k][j];
      if (a <= CARRIER[n] && b <= CARRIER[n]) M[i][j] += dot(F[a].axis, Iw[b]);
    }
}

/* M (6, 6) and h (6,): inertia, and centrifugal, Coriolis and gravity torques together. */
void arm_dynamics(const double *parameters, const double *q, const double *v, double *M, double *h) {
  const Arm *arm = (const Arm *)parameters;
  Frame F[NF];
  memset(M, 0, NQ * NQ * sizeof(double));
  memset(h, 0, NQ * sizeof(double));
  frames(q, v, F);
  for (int n = 0; n < NL; n++) add_link(arm, F, n, (double(*)[NQ])M, h);
}

/* Gravitational energy, and the handle's control point (3,). */
double arm_potential(const double *parameters, const double *q, double *handle) {
  const Arm *arm = (const Arm *)parameters;
  static const double rest[NQ] = {0};
  double energy = 0;
  Frame F[NF];
  Point p;
  frames(q, rest, F);
  for (int n = 0; n < NL; n++) {
    const double *c = arm->link[n].centroid;
    origin(arm, F, n, &p);
    add_piece(F, CARRIER[n], c[0], c[1], c[2], &p);
    energy += arm->link[n].mass * arm->gravity * p.r[2];
  }
  origin(arm, F, NL - 1, &p);
  add_piece(F, ROLL, 0, -arm->handle, 0, &p);
  memcpy(handle, p.r, sizeof p.r);
  return energy;
}

/* Solve A x = b in place by Cholesky for the free joints; the others get 0. */
static void solve(const int *is_free, double A[NQ][NQ], double *b) {
  int f[NQ], n = 0;
  for (int i = 0; i < NQ; i++) {
    if (is_free[i]) f[n++] = i;
    else b[i] = 0;
  }
  for (int i = 0; i < n; i++)
    for (int j = 0; j <= i; j++) {
      double s = A[f[i]][f[j]];
      for (int k = 0; k < j; k++) s -= A[f[i]][f[k]] * A[f[j]][f[k]];
      A[f[i]][f[j]] = i == j ? sqrt(s) : s / A[f[j]][f[j]];
    }
  for (int i = 0; i < n; i++) {
    for (int k = 0; k < i; k++) b[f[i]] -= A[f[i]][f[k]] * b[f[k]];
    b[f[i]] /= A[f[i]][f[i]];
  }
  for (int i = n - 1; i >= 0; i--) {
    for (int k = i + 1; k < n; k++) b[f[i]] -= A[f[k]][f[i]] * b[f[k]];
    b[f[i]] /= A[f[i]][f[i]];
  }
}

static double hidden_torque(const Hidden *d, double epos, double q, double v) {
  double slope = v > 0 ? d->drag_up : d->drag_down, x = q - epos;
  return d->cubic * x * x * x + d->cog * sin(d->cog_number * q + d->cog_phase) + slope * v + d->drag_square * fabs(v) * v;
}

/* Dry and viscous friction torque of a joint, and the rates of its states. */
static double friction_torque(const Friction *f, double v, const double *x, const double *slip, double *dx) {
  return dry_friction(f, friction_level(f, f->Fc, v), v, x, slip, dx) + f->sigma2 * v;
}

/* The rates of the first NS states. */
static void derivative(const Arm *arm, const Hidden *hidden, const int *is_free, const double *torque, const double *x,
                       const double *slip, double *dx) {
  double M[NQ][NQ], h[NQ], a[NQ];
  const double *q = x, *v = x + NQ;
  arm_dynamics((const double *)arm, q, v, &M[0][0], h);
  for (int j = 0; j < NQ; j++) {
    const Drive *d = &arm->drive[j];
    int own = INNER + j * ELEMENTS;
    double friction = friction_torque(&d->friction, v[j], x + own, slip + j * ELEMENTS, dx + own);
    double sent = torque[j] * (1 - hidden[j].gain_fall * torque[j] * torque[j]);
    a[j] = d->Kp * sent - h[j] - d->Ks * (q[j] - d->epos) - friction - hidden_torque(&hidden[j], d->epos, q[j], v[j]);
    dx[j] = v[j];
  }
  solve(is_free, M, a);
  memcpy(dx + NQ, a, sizeof a);
}

/* After a step: which elements of which joint slip. */
static void decide(const Arm *arm, double *x) {
  for (int j = 0; j < NQ; j++) {
    const Friction *f = &arm->drive[j].friction;
    double v = x[NQ + j];
    decide_slip(f, friction_level(f, f->Fc, v), v, x + INNER + j * ELEMENTS, x + NS + j * ELEMENTS);
  }
}

/* Advance the state by `steps` Runge-Kutta steps over `duration`; the torque runs linearly from u0 to u1. Locked joints
 * must have zero velocity; `disturbances` holds a Hidden per joint. Returns 0, or 1 when the state stopped being finite. */
int arm_advance(const double *parameters, const double *disturbances, const int *is_free, const double *u0,
                const double *u1, double duration, int steps, double *x) {
  const Arm *arm = (const Arm *)parameters;
  const Hidden *hidden = (const Hidden *)disturbances;
  double h = duration / steps, k[4][NS], y[NS], u[NQ];
  static const double node[4] = {0, 0.5, 0.5, 1}, weight[4] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
  for (int n = 0; n < steps; n++) {
    for (int s = 0; s < 4; s++) {
      for (int i = 0; i < NQ; i++) u[i] = u0[i] + (u1[i] - u0[i]) * (n + node[s]) / steps;
      for (int i = 0; i < NS; i++) y[i] = x[i] + (s ? h * node[s] * k[s - 1][i] : 0);
      derivative(arm, hidden, is_free, u, y, x + NS, k[s]);
    }
    for (int i = 0; i < NS; i++)
      for (int s = 0; s < 4; s++) x[i] += h * weight[s] * k[s][i];
    decide(arm, x);
  }
  for (int i = 0; i < NS; i++)
    if (!isfinite(x[i])) return 1;
  return 0;
}
