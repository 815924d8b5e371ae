/* The limit: Newton on a pair's two equations, one case a lane, by hand. Compiled by benches/peers.py with -DWIDTH=4 or 8.
 *
 * With u = k^0.4 sin(beta) and v = +- k^0.4 a cos(beta) a contact's force is (u d + v alpha)^1.5 and all that is summed is
 * S = sum sqrt(u d + v alpha) (u, v)(u, v)^T: the equations are S x = b, Newton's step is x/3 + 2/3 S^-1 b - x.
 */
#include <immintrin.h>
#include <math.h>
#include <stddef.h>

#if WIDTH == 8
typedef __m512d lanes;
#define splat _mm512_set1_pd
#define load _mm512_loadu_pd
#define store _mm512_storeu_pd
#define root(x) _mm512_sqrt_pd(_mm512_max_pd(x, _mm512_setzero_pd()))
#define biggest(x) _mm512_reduce_max_pd(x)
#define max2 _mm512_max_pd
#define magnitude _mm512_abs_pd
#else
typedef __m256d lanes;
#define splat _mm256_set1_pd
#define load _mm256_loadu_pd
#define store _mm256_storeu_pd
#define root(x) _mm256_sqrt_pd(_mm256_max_pd(x, _mm256_setzero_pd()))
#define max2 _mm256_max_pd
#define magnitude(x) _mm256_andnot_pd(_mm256_set1_pd(-0.0), x)
static double biggest(lanes x) {
    __m128d two = _mm_max_pd(_mm256_castpd256_pd128(x), _mm256_extractf128_pd(x, 1));
    return _mm_cvtsd_f64(_mm_max_sd(two, _mm_unpackhi_pd(two, two)));
}
#endif

/* From the response at rest, or from the starts in `approach` and `rotation` where `given`; `count` a multiple of WIDTH. */
size_t newton(size_t count, size_t contacts, const double *u, const double *v, double arm, int given,
              const double *torque, const double *preload, double *approach, double *rotation, double *residual) {
    double uu[64], uv[64], vv[64], axial = 0, turning = 0;
    for (size_t i = 0; i < contacts; i++) {
        uu[i] = u[i] * u[i], uv[i] = u[i] * v[i], vv[i] = v[i] * v[i];
        axial += uu[i] * sqrt(u[i]), turning += vv[i] * sqrt(u[i]);
    }
    if (!given)
        for (size_t c = 0; c < count; c++) {
            double third = cbrt(preload[c] / axial);
            approach[c] = third * third;
            rotation[c] = torque[c] / (1.5 * turning * third);
        }
    size_t passes = 0;
    for (size_t c = 0; c < count; c += WIDTH) {
        lanes b0 = load(preload + c), b1 = load(torque + c), d = load(approach + c), a = load(rotation + c), left;
        lanes scale0 = splat(1) / b0, scale1 = scale0 * splat(1 / arm);
        for (int pass = 0; pass < 50; pass++, passes++) {
            lanes s00 = splat(0), s01 = splat(0), s11 = splat(0);
            for (size_t i = 0; i < contacts; i++) {
                lanes weight = root(splat(u[i]) * d + splat(v[i]) * a);
                s00 += weight * splat(uu[i]), s01 += weight * splat(uv[i]), s11 += weight * splat(vv[i]);
            }
            lanes r0 = s00 * d + s01 * a - b0, r1 = s01 * d + s11 * a - b1;
            left = max2(magnitude(r0 * scale0), magnitude(r1 * scale1));
            lanes factor = splat(2.0 / 3) / (s00 * s11 - s01 * s01);
            d -= factor * (s11 * r0 - s01 * r1);
            a -= factor * (s00 * r1 - s01 * r0);
            if (biggest(left) <= 1e-11)
                break;
        }
        store(approach + c, d), store(rotation + c, a), store(residual + c, left);
    }
    return passes;
}
