/* The kernel on one flat buffer of doubles; HF_U ... HF_S are the places of the blocks. */

HF_API int hf_output(double *v, double t) {
    hk_output(t, v + HF_X, v + HF_U, v + HF_P, v + HF_Y);
    return 1;
}

/* One communication step: the state, and the outputs at its end. 0 where the state would leave the finite numbers: it stays as it was. */
HF_API int hf_step(double *v, double t, double dt) {
    double end[HK_NU + 1];
    int finite = hk_advance(v + HF_X, t, dt, v + HF_U, v + HF_SLOPE, v + HF_P, v[HF_H]);
    for (int j = 0; j < HK_NU; j++) end[j] = v[HF_U + j] + dt * v[HF_SLOPE + j];
    if (finite) hk_output(t + dt, v + HF_X, end, v + HF_P, v + HF_Y);
    return finite;
}

#ifdef HK_NC
HF_API int hf_output_tangent(double *v, double t) {
    hk_output_tangent(t, v + HF_X, v + HF_S, v + HF_U, v + HF_P, v + HF_Y, v + HF_DY);
    return 1;
}

HF_API int hf_step_tangent(double *v, double t, double dt) {
    double end[HK_NU + 1];
    int finite = hk_advance_tangent(v + HF_X, v + HF_S, t, dt, v + HF_U, v + HF_SLOPE, v + HF_P, v[HF_H]);
    for (int j = 0; j < HK_NU; j++) end[j] = v[HF_U + j] + dt * v[HF_SLOPE + j];
    if (finite) hk_output_tangent(t + dt, v + HF_X, v + HF_S, end, v + HF_P, v + HF_Y, v + HF_DY);
    return finite;
}
#endif
