// The plugin: parameters, and the functions of the border. Nothing here throws.
#include "element.hpp"

#include <cstdio>
#include <cstring>
#include <new>

namespace {
using namespace corotational;

enum Param : uint32_t { YOUNG, POISSON, DENSITY, DAMPING_TIME, TANGENT, PARAMS };

const pliant_param params[PARAMS] = {
    {PLIANT_PARAM_NUMBER, "young", "Pa", "Young's modulus", 1e-6, 1e12, 1e4, nullptr},
    {PLIANT_PARAM_NUMBER, "poisson", "1", "Poisson's ratio", 0.0, 0.499, 0.3, nullptr},
    {PLIANT_PARAM_NUMBER, "density", "kg/m^3", "mass per volume", 1e-6, 1e6, 1e3, nullptr},
    {PLIANT_PARAM_NUMBER, "damping-time", "s", "damping over stiffness: a mode of w rad/s has ratio w/2 times this", 0.0,
     10.0, 2e-4, nullptr},
    {PLIANT_PARAM_CHOICE, "tangent", "1", "the matrix of implicit steps: without its negative part, or exact", 0.0, 1.0,
     0.0, "projected|exact"},
};

const pliant_descriptor descriptor = {
    sizeof(pliant_descriptor),
    PLIANT_KIND_MATERIAL,
    PLIANT_FLAG_REAL_TIME | PLIANT_FLAG_DETERMINISTIC,
    "corotational",
    "Corotational solid",
    "0.1.0",
    "linear elasticity in frames that turn with the elements (Etzmuss et al. 2003; Mueller and Gross 2004)",
    params,
    PARAMS,
    sizeof(pliant_param),
};

struct Instance {
  pliant_plugin plugin;
  const pliant_host *host;
  double values[PARAMS];
  Law law;
};

Instance &self(const pliant_plugin *p) noexcept { return *static_cast<Instance *>(p->data); }
const Law &law(const pliant_plugin *p) noexcept { return self(p).law; }

pliant_status fail(const pliant_plugin *p, pliant_status status, const char *why) noexcept {
  const pliant_host *host = self(p).host;
  if (host && host->report) host->report(host, PLIANT_ERROR, why);
  return status;
}

pliant_status finite(const pliant_plugin *p, double value) noexcept {
  return std::isfinite(value) ? PLIANT_OK : fail(p, PLIANT_DIVERGED, "a tetrahedron's state is not finite");
}

// ---- material ----

pliant_status elements(const pliant_plugin *p, uint32_t index, pliant_element_request *out) noexcept {
  if (index > 1) return PLIANT_UNSUPPORTED;
  *out = {sizeof *out, PLIANT_POINT, 0, PLIANT_HAS_MASS, 0, 0};
  if (index == 1) {
    out->kind = PLIANT_TETRAHEDRON;
    out->flags = PLIANT_HAS_FORCES | (law(p).eta > 0.0 ? PLIANT_HAS_DAMPING : 0u);
    out->rest_stride = STRIDE;
  }
  return PLIANT_OK;
}

pliant_status rest(const pliant_plugin *p, const pliant_batch *b, double *data) noexcept {
  for (size_t e = b->begin; e < b->end; e++)
    if (!Tetrahedron::measure(corners(*b, e, b->rest), b->measure[e], data + e, b->count))
      return fail(p, PLIANT_BAD_ARGUMENT, "a tetrahedron has no volume at rest, or is inside out");
  return PLIANT_OK;
}

pliant_status mass(const pliant_plugin *p, const pliant_batch *b, double *out) noexcept {
  for (size_t e = b->begin; e < b->end; e++) out[b->elements[e]] += law(p).density * b->measure[e];
  return PLIANT_OK;
}

pliant_status energy(const pliant_plugin *p, const pliant_batch *b, double *out) noexcept {
  double sum = 0.0;
  for (size_t e = b->begin; e < b->end; e++) {
    const Tetrahedron t(*b, e);
    sum += t.volume * corotational::energy(law(p), t.derivative(corners(*b, e, b->x)));
  }
  *out += sum;
  return finite(p, sum);
}

pliant_status forces(const pliant_plugin *p, const pliant_batch *b, double *out) noexcept {
  double seen = 0.0;
  for (size_t e = b->begin; e < b->end; e++) {
    const Tetrahedron t(*b, e);
    const M3 f = t.derivative(corners(*b, e, b->x));
    M3 s = stress(law(p), f);
    if (law(p).eta > 0.0) add_viscous_stress(law(p), f, t.derivative(corners(*b, e, b->v)), s);
    for (size_t a = 0; a < 4; a++) {
      const V3 force = scaled(-t.volume, times(s, t.gradient[a]));
      double *to = out + 3 * size_t{b->elements[4 * e + a]};
      for (int i = 0; i < 3; i++) to[i] += force[i];
      if (a > 0) seen += force[a - 1];
    }
  }
  return finite(p, seen);
}

pliant_status tangent(const pliant_plugin *p, const pliant_batch *b, double stiffness, double damping,
                      const pliant_blocks *to) noexcept {
  for (size_t e = b->begin; e < b->end; e++) {
    const Tetrahedron t(*b, e);
    const M3 f = t.derivative(corners(*b, e, b->x));
    if (stiffness != 0.0) add_stiffness(law(p), t, f, stiffness, *to, 10 * e);
    if (damping != 0.0 && law(p).eta > 0.0) add_viscosity(law(p), t, f, damping, *to, 10 * e);
  }
  return PLIANT_OK;
}

const pliant_material material = {
    sizeof(pliant_material), elements, rest, mass, energy, forces, tangent, nullptr, nullptr,
};

// ---- instance ----

void destroy(const pliant_plugin *p) noexcept { delete &self(p); }

pliant_status set_number(const pliant_plugin *p, uint32_t index, double value) noexcept {
  if (index >= PARAMS) return fail(p, PLIANT_BAD_ARGUMENT, "no such parameter");
  const pliant_param &param = params[index];
  const bool whole = param.kind != PLIANT_PARAM_CHOICE || value == std::floor(value);
  if (!(value >= param.min && value <= param.max && whole)) {
    char line[128];
    std::snprintf(line, sizeof line, "%s is %g; allowed is %g to %g", param.key, value, param.min, param.max);
    return fail(p, PLIANT_BAD_ARGUMENT, line);
  }
  self(p).values[index] = value;
  return PLIANT_OK;
}

pliant_status set_text(const pliant_plugin *p, uint32_t, const char *) noexcept {
  return fail(p, PLIANT_BAD_ARGUMENT, "no parameter is a text");
}

pliant_status set_table(const pliant_plugin *p, uint32_t, const double *, size_t, size_t) noexcept {
  return fail(p, PLIANT_BAD_ARGUMENT, "no parameter is a table");
}

pliant_status activate(const pliant_plugin *p, const pliant_limits *) noexcept {
  const double *v = self(p).values;
  Law &l = self(p).law;
  l.mu = v[YOUNG] / (2.0 * (1.0 + v[POISSON]));
  l.lambda = v[YOUNG] * v[POISSON] / ((1.0 + v[POISSON]) * (1.0 - 2.0 * v[POISSON]));
  l.density = v[DENSITY];
  l.eta = v[DAMPING_TIME] * l.mu;
  l.zeta = v[DAMPING_TIME] * l.lambda;
  l.project = v[TANGENT] == 0.0;
  return PLIANT_OK;
}

void deactivate(const pliant_plugin *) noexcept {}

const void *extension(const pliant_plugin *, const char *id) noexcept {
  return std::strcmp(id, PLIANT_MATERIAL) == 0 ? &material : nullptr;
}

}  // namespace

// The library's three functions; src/lib.rs puts them into the exported table.
extern "C" pliant_status corotational_init(const pliant_host *, const char *) noexcept { return PLIANT_OK; }

extern "C" const pliant_descriptor *corotational_descriptor(uint32_t index) noexcept {
  return index == 0 ? &descriptor : nullptr;
}

extern "C" const pliant_plugin *corotational_create(const pliant_host *host, const char *id) noexcept {
  if (std::strcmp(id, descriptor.id) != 0) return nullptr;
  Instance *made = new (std::nothrow) Instance{};
  if (!made) return nullptr;
  made->plugin = {sizeof(pliant_plugin), &descriptor, made, destroy, set_number, set_text, set_table, activate, deactivate,
                  extension};
  made->host = host;
  for (uint32_t i = 0; i < PARAMS; i++) made->values[i] = params[i].fallback;
  return &made->plugin;
}
