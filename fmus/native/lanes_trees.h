/* Sum of regression trees. A leaf points to itself, so that many walks take steps side by side without a branch that
   the processor would have to guess; a tree's depth says when all have arrived. */

typedef struct {
    double value; /* the threshold of a node, the value of a leaf */
    tf_index feature, next[2]; /* next node within the tree: the first where the feature is <= the threshold */
} tf_tree_node;

typedef struct {
    int first, depth;
} tf_tree;

/* One point: eight trees side by side. */
TF_APART double tf_trees(const double *x, const tf_tree_node *nodes, const tf_tree *trees, int count) {
    double sum = 0.0;
    for (int t = 0; t < count; t += 8) {
        const int width = count - t < 8 ? count - t : 8;
        const tf_tree_node *root[8];
        unsigned at[8];
        int depth = 0;
        for (int k = 0; k < 8; ++k) {
            const tf_tree *tree = trees + t + (k < width ? k : 0);
            root[k] = nodes + tree->first;
            at[k] = 0;
            depth = tree->depth > depth ? tree->depth : depth;
        }
        for (int d = 0; d < depth; ++d)
            for (int k = 0; k < 8; ++k) {
                const tf_tree_node *node = root[k] + at[k];
                at[k] = node->next[!(x[node->feature] <= node->value)];
            }
        for (int k = 0; k < width; ++k) sum += root[k][at[k]].value;
    }
    return sum;
}

/* A block of points: one tree after the other, all points side by side. */
TF_APART void tf_trees_block(double *y, const double *x, const tf_tree_node *nodes, const tf_tree *trees, int count) {
    for (int l = 0; l < TF_BLOCK; ++l) y[l] = 0.0;
    for (int t = 0; t < count; ++t) {
        const tf_tree_node *root = nodes + trees[t].first;
        unsigned at[TF_BLOCK] = {0};
        for (int d = 0; d < trees[t].depth; ++d)
            for (int l = 0; l < TF_BLOCK; ++l) {
                const tf_tree_node *node = root + at[l];
                at[l] = node->next[!(x[node->feature * TF_BLOCK + l] <= node->value)];
            }
        for (int l = 0; l < TF_BLOCK; ++l) y[l] += root[at[l]].value;
    }
}
