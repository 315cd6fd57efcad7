/* y = bias + x W, W row by row (inputs x outputs). Sums run over the inputs in order, for one point as for a block;
   with one output, over four partial sums, because a single chain of additions would wait for each of them. */

/* `width` outputs of one point. */
TF_INLINE void tf_dense_part(double *y, const double *x, const double *w, const double *bias, int inputs, int outputs,
                             const int width, const int fused) {
    double sum[32];
    for (int j = 0; j < width; ++j) sum[j] = bias ? bias[j] : 0.0;
    for (int i = 0; i < inputs; ++i)
        for (int j = 0; j < width; ++j) sum[j] = TF_FMA(x[i], w[i * outputs + j], sum[j]);
    for (int j = 0; j < width; ++j) y[j] = sum[j];
}

TF_INLINE void tf_dense_body(double *y, const double *x, const double *w, const double *bias, int inputs, int outputs,
                             const int fused) {
    int j = 0;
    if (outputs == 1) {
        double sum[4] = {bias ? bias[0] : 0.0, 0.0, 0.0, 0.0};
        int i = 0;
        for (; i + 4 <= inputs; i += 4)
            for (int k = 0; k < 4; ++k) sum[k] = TF_FMA(x[i + k], w[i + k], sum[k]);
        for (; i < inputs; ++i) sum[i & 3] = TF_FMA(x[i], w[i], sum[i & 3]);
        y[0] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
        return;
    }
#define TF_PARTS(width) \
    for (; j + width <= outputs; j += width) \
        tf_dense_part(y + j, x, w + j, bias ? bias + j : bias, inputs, outputs, width, fused);
    if (fused) {
        TF_PARTS(32)
    }
    TF_PARTS(16)
    TF_PARTS(4)
    TF_PARTS(1)
#undef TF_PARTS
}

/* `width` outputs of `lanes` points of a block, their sums in registers. */
TF_INLINE void tf_dense_tile(double *y, const double *x, const double *w, const double *bias, int inputs, int outputs,
                             const int width, const int lanes, const int fused) {
    double sum[32];
    for (int j = 0; j < width; ++j)
        for (int l = 0; l < lanes; ++l) sum[j * lanes + l] = bias ? bias[j] : 0.0;
    for (int i = 0; i < inputs; ++i)
        for (int j = 0; j < width; ++j) {
            const double weight = w[i * outputs + j];
            for (int l = 0; l < lanes; ++l)
                sum[j * lanes + l] = TF_FMA(x[i * TF_BLOCK + l], weight, sum[j * lanes + l]);
        }
    for (int j = 0; j < width; ++j)
        for (int l = 0; l < lanes; ++l) y[j * TF_BLOCK + l] = sum[j * lanes + l];
}

/* The one output of `lanes` points. */
TF_INLINE void tf_dense_last(double *y, const double *x, const double *w, const double *bias, int inputs,
                             const int lanes, const int fused) {
    double sum[32];
    for (int k = 0; k < 4; ++k)
        for (int l = 0; l < lanes; ++l) sum[k * lanes + l] = bias && k == 0 ? bias[0] : 0.0;
    int i = 0;
    for (; i + 4 <= inputs; i += 4)
        for (int k = 0; k < 4; ++k)
            for (int l = 0; l < lanes; ++l)
                sum[k * lanes + l] = TF_FMA(x[(i + k) * TF_BLOCK + l], w[i + k], sum[k * lanes + l]);
    for (int k = 0; i + k < inputs; ++k)
        for (int l = 0; l < lanes; ++l)
            sum[k * lanes + l] = TF_FMA(x[(i + k) * TF_BLOCK + l], w[i + k], sum[k * lanes + l]);
    for (int l = 0; l < lanes; ++l) y[l] = (sum[l] + sum[lanes + l]) + (sum[2 * lanes + l] + sum[3 * lanes + l]);
}

TF_WIDE void tf_dense_wide(double *y, const double *x, const double *w, const double *bias, int inputs, int outputs) {
    tf_dense_body(y, x, w, bias, inputs, outputs, 1);
}
TF_APART void tf_dense_plain(double *y, const double *x, const double *w, const double *bias, int inputs, int outputs) {
    tf_dense_body(y, x, w, bias, inputs, outputs, 0);
}
TF_INLINE void tf_dense(double *y, const double *x, const double *w, const double *bias, int inputs, int outputs,
                        const int fused) {
    if (fused) tf_dense_wide(y, x, w, bias, inputs, outputs);
    else tf_dense_plain(y, x, w, bias, inputs, outputs);
}

/* 4 lanes x 4 outputs: 8 of the 16 registers of SSE2. */
TF_APART void tf_dense_block_plain(double *y, const double *x, const double *w, const double *bias, int inputs,
                                   int outputs) {
    const int quads = outputs - outputs % 4;
    for (int l = 0; l < TF_BLOCK; l += 4) {
        if (outputs == 1) {
            tf_dense_last(y + l, x + l, w, bias, inputs, 4, 0);
            continue;
        }
        for (int j = 0; j < quads; j += 4)
            tf_dense_tile(y + j * TF_BLOCK + l, x + l, w + j, bias ? bias + j : bias, inputs, outputs, 4, 4, 0);
        for (int j = quads; j < outputs; ++j)
            tf_dense_tile(y + j * TF_BLOCK + l, x + l, w + j, bias ? bias + j : bias, inputs, outputs, 1, 4, 0);
    }
}

#if TF_WIDE_BUILD
/* The wide build of the same, with the vectors written out: not every compiler finds them. */
typedef double tf_vector __attribute__((vector_size(32), aligned(8), may_alias));

#if defined(__clang__)
#define TF_FMA_VECTOR(a, b, c) __builtin_elementwise_fma(a, b, c)
#else
#define TF_FMA_VECTOR(a, b, c) __builtin_ia32_vfmaddpd256(a, b, c)
#endif

/* 8 lanes x 4 outputs: 8 of the 16 registers of AVX2. */
TF_INLINE_WIDE void tf_dense_tile_wide(double *y, const double *x, const double *w, const double *bias, int inputs,
                                       int outputs, const int width) {
    tf_vector sum[4][2];
    for (int j = 0; j < width; ++j) {
        const double start = bias ? bias[j] : 0.0;
        sum[j][0] = sum[j][1] = (tf_vector){start, start, start, start};
    }
    for (int i = 0; i < inputs; ++i) {
        const tf_vector low = *(const tf_vector *)(x + i * TF_BLOCK), high = *(const tf_vector *)(x + i * TF_BLOCK + 4);
        for (int j = 0; j < width; ++j) {
            const double one = w[i * outputs + j];
            const tf_vector weight = {one, one, one, one};
            sum[j][0] = TF_FMA_VECTOR(low, weight, sum[j][0]);
            sum[j][1] = TF_FMA_VECTOR(high, weight, sum[j][1]);
        }
    }
    for (int j = 0; j < width; ++j) {
        *(tf_vector *)(y + j * TF_BLOCK) = sum[j][0];
        *(tf_vector *)(y + j * TF_BLOCK + 4) = sum[j][1];
    }
}

TF_WIDE void tf_dense_block_wide(double *y, const double *x, const double *w, const double *bias, int inputs,
                                 int outputs) {
    const int quads = outputs - outputs % 4;
    for (int l = 0; l < TF_BLOCK; l += 8) {
        if (outputs == 1) {
            tf_dense_last(y + l, x + l, w, bias, inputs, 8, 1);
            continue;
        }
        for (int j = 0; j < quads; j += 4)
            tf_dense_tile_wide(y + j * TF_BLOCK + l, x + l, w + j, bias ? bias + j : bias, inputs, outputs, 4);
        for (int j = quads; j < outputs; ++j)
            tf_dense_tile_wide(y + j * TF_BLOCK + l, x + l, w + j, bias ? bias + j : bias, inputs, outputs, 1);
    }
}
#else
#define tf_dense_block_wide tf_dense_block_plain
#endif

TF_INLINE void tf_dense_block(double *y, const double *x, const double *w, const double *bias, int inputs, int outputs,
                              const int fused) {
    if (fused) tf_dense_block_wide(y, x, w, bias, inputs, outputs);
    else tf_dense_block_plain(y, x, w, bias, inputs, outputs);
}
