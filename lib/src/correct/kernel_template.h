/* SPDX-License-Identifier: MIT */
/* The loops of the float path for one instruction set. Included by kernel.c with
 *   ISA(name)   the name with the set's suffix
 *   TARGET      the attribute that turns the set on, or nothing
 *   POOR        1 for SSE2: gcc finds no shuffles there between three planes and pixels, which then
 *               get loops of their own, and no instruction for the larger of two unsigned integers
 * All loops run over whole blocks, so their length is known, and use no operation whose result
 * could differ between sets: no fused multiply-add, no reciprocal estimates, no reordered sums. */

/* Is a value negative (or -0), NaN, infinite or 2^64 and more? Such are large as unsigned integers:
 * a loop keeps the largest, and asks at its end. */
INNER uint32_t ISA(doubt)(float x)
{
    const uint32_t u = (uint32_t)ISA(bits)(x);

    return POOR ? u | (u + 0x20800000u) : u;
}

INNER uint32_t ISA(larger)(uint32_t a, uint32_t b) { return POOR ? a | b : a > b ? a : b; }

INNER uint32_t ISA(doubt_of_three)(float x, float y, float z)
{
    return ISA(larger)(ISA(larger)(ISA(doubt)(x), ISA(doubt)(y)), ISA(doubt)(z));
}

INNER int ISA(is_suspect)(uint32_t worst) { return worst >= (POOR ? 0x80000000u : 0x5F800000u); }

/* Linear RGB of pixel j to X, Y, Z over white; Ynew. Returns doubt of it. */
INNER uint32_t ISA(light)(const lcor_kernel_constants *k, float zero, float one, float r, float g,
                          float bl, size_t j, lcor_block *b)
{
    const float y = r * k->m[1][0] + g * k->m[1][1] + bl * k->m[1][2]; /* eq 1 */

    b->c[0][j] = r * k->m[0][0] + g * k->m[0][1] + bl * k->m[0][2];
    b->c[1][j] = y;
    b->c[2][j] = r * k->m[2][0] + g * k->m[2][1] + bl * k->m[2][2];
    b->c[3][j] = ISA(clamp)(b->v[j] * y + k->w, zero, one); /* eq 11, or T itself; rule S7 */
    return ISA(doubt_of_three)(r, g, bl);
}

#if POOR
STAGE int ISA(lightness_of_planes)(const lcor_kernel_constants *k, lcor_block *restrict b);
#endif

STAGE int ISA(lightness)(const lcor_kernel_constants *k, const float *restrict rgb,
                         lcor_block *restrict b)
{
#if POOR
    EACH (j, LCOR_BLOCK)
        for (size_t i = 0; i < 3; i++)
            b->c[i][j] = rgb[3 * j + i];
    return ISA(lightness_of_planes)(k, b);
#else
    const lcor_kernel_constants q = *k;
    const float zero = ISA(limits).zero, one = ISA(limits).one;
    uint32_t worst = 0;

    EACH (j, LCOR_BLOCK)
        worst = ISA(larger)(
            worst, ISA(light)(&q, zero, one, rgb[3 * j], rgb[3 * j + 1], rgb[3 * j + 2], j, b));
    return ISA(is_suspect)(worst);
#endif
}

/* 1 - f of eqs 2-4 over planes. Two loops, since a processor looks ahead over so many instructions
 * only: of two short chains of them it overlaps more than of a long one. So below. */
STAGE void ISA(g)(const float *restrict t, float *restrict g, size_t planes)
{
    const float knee = ISA(limits).knee;

    for (; planes > 0; planes--, t += LCOR_BLOCK, g += LCOR_BLOCK) {
        float LCOR_ALIGNED c0[LCOR_BLOCK], e[LCOR_BLOCK];

        EACH (j, LCOR_BLOCK) {
            const float m = ISA(at_least)(t[j], knee);
            const float z = ISA(inverse_root)(m);
            const float root = m * z * z;

            c0[j] = root;
            e[j] = root * z - 1.0f;
            g[j] = (t[j] - m) * 7.78703703f; /* 841/108 */
        }
        EACH (j, LCOR_BLOCK)
            g[j] = ISA(g_of)(c0[j], e[j], g[j]);
    }
}

/* k of eq 16, new chroma, and back to linear RGB, not yet clamped. */
STAGE void ISA(chroma)(const lcor_kernel_constants *k, lcor_block *restrict b)
{
    const float r_x = k->n[0][0], r_z = k->n[0][1], g_x = k->n[1][0], g_z = k->n[1][1];
    const float b_x = k->n[2][0], b_z = k->n[2][1];
    const float zero = ISA(limits).zero, near_white = ISA(limits).near_white,
                knee = ISA(limits).f_knee;

    EACH (j, LCOR_BLOCK) {
        const float gy = b->g[1][j], gn = ISA(at_least)(b->g[3][j], zero);
        /* Both branches of eq 16 are (h - gn) / (h - gy). White stays white: 0 < 1e-9 and k is 0,
         * whatever the texel; 1e-20 only keeps 0 / 0 away (rules S5, S6). */
        const float h = gn < ISA(at_least)(gy, near_white) ? 0.0f : G_BLACK;
        const float chroma = (h - gn) / (h - gy - 1e-20f);

        b->c[0][j] = (1.0f - gn) + chroma * (gy - b->g[0][j]); /* eq 14 */
        b->c[2][j] = (1.0f - gn) + chroma * (gy - b->g[2][j]); /* eq 15 */
    }
    EACH (j, LCOR_BLOCK) {
        const float y_new = b->c[3][j];
        const float dx = ISA(f_inverse)(b->c[0][j], knee) - y_new;
        const float dz = ISA(f_inverse)(b->c[2][j], knee) - y_new;

        b->c[0][j] = y_new + (r_x * dx + r_z * dz);
        b->c[1][j] = y_new + (g_x * dx + g_z * dz);
        b->c[2][j] = y_new + (b_x * dx + b_z * dz);
    }
}
