/* ---- a neural network as the energy of a spring ---- */

/* Energy density by Green's strain: two hidden layers and positive weights behind the first, so it is convex (Amos, Xu and Kolter 2017). */
enum { WIDTH = 8, TILE = 64 };
static const double INPUT[WIDTH] = {3.0, -2.5, 1.5, -1.0, 5.0, -4.0, 0.5, 2.0};
static const double INPUT_BIAS[WIDTH] = {0.1, -0.2, 0.4, 0.3, -0.6, 0.2, -0.1, -0.3};
static const double HIDDEN_BIAS[WIDTH] = {-0.5, 0.2, -1.0, 0.3, -0.2, 0.6, -0.8, 0.1};
static const double OUTPUT[WIDTH] = {0.4, 0.2, 0.6, 0.1, 0.3, 0.5, 0.2, 0.7};

/* Weight of neuron i of the first layer in neuron j of the second. */
static double hidden(int i, int j) { return (1 + (3 * i + 5 * j) % 7) / 14.0; }

/* A function of the strain with its first and second derivative. */
typedef struct jet {
  double value, slope, curvature;
} jet;

/* (z + sqrt(z^2 + 1)) / 2 of a jet z: like softplus, without functions whose bits depend on the platform. */
static jet activate_neuron(jet z) {
  const double root = sqrt(z.value * z.value + 1.0), first = 0.5 * (1.0 + z.value / root);
  const double second = 0.5 / (root * root * root);
  const jet out = {0.5 * (z.value + root), first * z.slope, second * z.slope * z.slope + first * z.curvature};
  return out;
}

/* Evaluates the network for `count` strains, at most TILE, layer by layer. */
static void evaluate(size_t count, const double *strain, jet *out) {
  jet layer[WIDTH][TILE];
  size_t k;
  int i, j;
  for (i = 0; i < WIDTH; i++)
    for (k = 0; k < count; k++) {
      const jet z = {INPUT[i] * strain[k] + INPUT_BIAS[i], INPUT[i], 0.0};
      layer[i][k] = activate_neuron(z);
    }
  for (k = 0; k < count; k++) out[k].value = out[k].slope = out[k].curvature = 0.0;
  for (j = 0; j < WIDTH; j++)
    for (k = 0; k < count; k++) {
      jet z = {HIDDEN_BIAS[j], 0.0, 0.0};
      for (i = 0; i < WIDTH; i++) {
        z.value += hidden(i, j) * layer[i][k].value;
        z.slope += hidden(i, j) * layer[i][k].slope;
        z.curvature += hidden(i, j) * layer[i][k].curvature;
      }
      z = activate_neuron(z);
      out[k].value += OUTPUT[j] * z.value;
      out[k].slope += OUTPUT[j] * z.slope;
      out[k].curvature += OUTPUT[j] * z.curvature;
    }
}

/* Waits as long as it takes until a GPU or a process that computes the network has a call. */
static void wait_for_device(const pliant_plugin *p, const pliant_batch *b) {
  const pliant_host *host = self(p)->host;
  struct timespec start, now;
  if (b->end - b->begin < b->count && host && host->report)
    host->report(host, PLIANT_WARNING, "a call has a part of the list, and waits as long as one for all of it");
  timespec_get(&start, TIME_UTC);
  do timespec_get(&now, TIME_UTC);
  while ((now.tv_sec - start.tv_sec) + 1e-9 * (now.tv_nsec - start.tv_nsec) < self(p)->values[LATENCY]);
}

/* Springs of a call, as many as the network takes at a time: strains, and the energy over k L^2 with its derivatives by the strain. */
typedef struct tile {
  size_t begin, count;
  jet of[TILE];
} tile;

/* Computes the next tile; returns 0 behind the last. Energy and force are zero at rest, and the stiffness is that of the linear spring. */
static int next_tile(const pliant_batch *b, tile *t) {
  const double none = 0.0;
  double strain[TILE];
  jet rest;
  size_t k;
  t->begin += t->count;
  t->count = b->end - t->begin < TILE ? b->end - t->begin : TILE;
  if (t->count == 0) return 0;
  for (k = 0; k < t->count; k++) {
    double n[3];
    const double ratio = length_and_direction(b, t->begin + k, b->x, n) / rest_length(b, t->begin + k);
    strain[k] = 0.5 * (ratio * ratio - 1.0);
  }
  evaluate(1, &none, &rest);
  evaluate(t->count, strain, t->of);
  for (k = 0; k < t->count; k++) {
    t->of[k].value = (t->of[k].value - rest.value - rest.slope * strain[k]) / rest.curvature;
    t->of[k].slope = (t->of[k].slope - rest.slope) / rest.curvature;
    t->of[k].curvature /= rest.curvature;
  }
  return 1;
}

static pliant_status energy(const pliant_plugin *p, const pliant_batch *b, double *out) {
  tile t;
  double sum = 0.0;
  size_t k;
  wait_for_device(p, b);
  t.begin = b->begin, t.count = 0;
  while (next_tile(b, &t))
    for (k = 0; k < t.count; k++) {
      const double length = rest_length(b, t.begin + k);
      sum += stiffness_of(b, t.begin + k) * length * length * t.of[k].value;
    }
  *out += sum;
  return isfinite(sum) ? PLIANT_OK : fail(p, PLIANT_DIVERGED, "the energy is not finite");
}

static pliant_status forces(const pliant_plugin *p, const pliant_batch *b, double *force) {
  tile t;
  double sum = 0.0; /* not finite if a tension is not */
  size_t k;
  wait_for_device(p, b);
  t.begin = b->begin, t.count = 0;
  while (next_tile(b, &t))
    for (k = 0; k < t.count; k++) {
      const size_t e = t.begin + k, i = b->elements[2 * e], j = b->elements[2 * e + 1];
      double n[3], rate = 0.0, tension;
      const double length = length_and_direction(b, e, b->x, n);
      int c;
      for (c = 0; c < 3; c++) rate += n[c] * (b->v[3 * j + c] - b->v[3 * i + c]);
      tension = stiffness_of(b, e) * (t.of[k].slope * length + self(p)->values[DAMPING_TIME] * rate);
      for (c = 0; c < 3; c++) {
        force[3 * i + c] += tension * n[c];
        force[3 * j + c] -= tension * n[c];
      }
      sum += tension;
    }
  return isfinite(sum) ? PLIANT_OK : fail(p, PLIANT_DIVERGED, "a force is not finite");
}

static pliant_status tangent(const pliant_plugin *p, const pliant_batch *b, double stiffness, double damping,
                             const pliant_blocks *blocks) {
  tile t;
  size_t k;
  wait_for_device(p, b);
  t.begin = b->begin, t.count = 0;
  while (next_tile(b, &t))
    for (k = 0; k < t.count; k++) {
      const size_t e = t.begin + k;
      double n[3], block[9], negative[9];
      const double length = length_and_direction(b, e, b->x, n), ratio = length / rest_length(b, e);
      /* A compressed spring would push its ends aside; 0 instead keeps the matrix positive semi-definite. */
      const double transverse = stiffness * stiffness_of(b, e) * (t.of[k].slope > 0.0 ? t.of[k].slope : 0.0);
      const double axial = stiffness_of(b, e) * (stiffness * ratio * ratio * t.of[k].curvature + damping * self(p)->values[DAMPING_TIME]);
      int i;
      for (i = 0; i < 9; i++) {
        block[i] = axial * n[i / 3] * n[i % 3] + (i % 4 == 0 ? transverse : 0.0);
        negative[i] = -block[i];
      }
      pliant_add_block(blocks, 3 * e, block);
      pliant_add_block(blocks, 3 * e + 1, negative);
      pliant_add_block(blocks, 3 * e + 2, block);
    }
  return PLIANT_OK;
}

