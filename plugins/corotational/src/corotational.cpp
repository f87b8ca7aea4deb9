// The plugin: parameters, and the functions of the C interface. Nothing here throws.
#include "element.hpp"

#include <cstdio>
#include <cstring>
#include <new>

namespace {
using namespace corotational;

enum Param : uint32_t { YOUNG, POISSON, DENSITY, DAMPING_TIME, TANGENT, PARAMS };

const pliant_param params[PARAMS] = {
    {PLIANT_PARAM_NUMBER, "young", "Pa", "Young's modulus", 1e-6, 1e12, 1e4, nullptr, PLIANT_PARAM_FIELD},
    {PLIANT_PARAM_NUMBER, "poisson", "1", "Poisson's ratio", 0.0, 0.499, 0.3, nullptr, 0},
    {PLIANT_PARAM_NUMBER, "density", "kg/m^3", "mass per volume", 1e-6, 1e6, 1e3, nullptr, PLIANT_PARAM_FIELD},
    {PLIANT_PARAM_NUMBER, "damping-time", "s", "damping over stiffness: a mode of w rad/s has a damping ratio of w/2 times this",
     0.0, 10.0, 2e-4, nullptr, 0},
    {PLIANT_PARAM_CHOICE, "tangent", "1", "matrix of implicit steps: made positive semi-definite, or exact", 0.0, 1.0, 0.0,
     "projected|exact", 0},
};

const pliant_descriptor descriptor = {
    sizeof(pliant_descriptor),
    PLIANT_KIND_MATERIAL,
    PLIANT_FLAG_REAL_TIME | PLIANT_FLAG_DETERMINISTIC,
    "corotational",
    "Corotational solid",
    "0.1.0",
    "linear elasticity in frames that rotate with the elements (Etzmuss et al. 2003; Mueller and Gross 2004)",
    params,
    PARAMS,
    sizeof(pliant_param),
};

// Parameters that are fields, in the order of their declaration.
enum FieldParam : size_t { FIELD_YOUNG, FIELD_DENSITY };

// Factor of a field parameter in element `e`.
double factor(const double *field, size_t e) noexcept { return field ? field[e] : 1.0; }

// An instance, from create to destroy.
struct Instance {
  pliant_plugin plugin;
  const pliant_host *host;
  double values[PARAMS];
  Law law;
};

Instance &self(const pliant_plugin *p) noexcept { return *static_cast<Instance *>(p->data); }
const Law &law(const pliant_plugin *p) noexcept { return self(p).law; }

// Reports the reason to the host and returns the status.
pliant_status fail(const pliant_plugin *p, pliant_status status, const char *reason) noexcept {
  const pliant_host *host = self(p).host;
  if (host && host->report) host->report(host, PLIANT_ERROR, reason);
  return status;
}

// OK, or a fault if `value` is not finite.
pliant_status check_finite(const pliant_plugin *p, double value) noexcept {
  return std::isfinite(value) ? PLIANT_OK : fail(p, PLIANT_DIVERGED, "a tetrahedron's state is not finite");
}

// ---- material ----

pliant_status elements(const pliant_plugin *p, uint32_t index, pliant_element_request *out) noexcept {
  if (index > 1) return PLIANT_UNSUPPORTED;
  *out = {sizeof *out, PLIANT_POINT, 0, PLIANT_HAS_MASS, 0, 0};
  if (index == 1) {
    out->kind = PLIANT_TETRAHEDRON;
    out->flags = PLIANT_HAS_FORCES | (law(p).viscosity_shear > 0.0 ? PLIANT_HAS_DAMPING : 0u);
    out->rest_stride = STRIDE;
  }
  return PLIANT_OK;
}

pliant_status rest(const pliant_plugin *p, const pliant_batch *b, double *data) noexcept {
  const double *young = pliant_field(b, FIELD_YOUNG);
  // Energy and stress are proportional to Young's modulus and to the volume, so the volume takes the factor of both.
  for (size_t e = b->begin; e < b->end; e++)
    if (!Tetrahedron::write_rest_data(at_corners(*b, e, b->rest), b->measure[e] * factor(young, e), data + e, b->count))
      return fail(p, PLIANT_BAD_ARGUMENT, "a tetrahedron has no volume at rest, or is inverted");
  return PLIANT_OK;
}

pliant_status mass(const pliant_plugin *p, const pliant_batch *b, double *out) noexcept {
  const double *density = pliant_field(b, FIELD_DENSITY);
  for (size_t e = b->begin; e < b->end; e++) out[b->elements[e]] += law(p).density * factor(density, e) * b->measure[e];
  return PLIANT_OK;
}

pliant_status energy(const pliant_plugin *p, const pliant_batch *b, double *out) noexcept {
  double sum = 0.0;
  for (size_t e = b->begin; e < b->end; e++) {
    const Tetrahedron t(*b, e);
    sum += t.volume * corotational::energy(law(p), t.deformation_gradient(at_corners(*b, e, b->x)));
  }
  *out += sum;
  return check_finite(p, sum);
}

pliant_status forces(const pliant_plugin *p, const pliant_batch *b, double *out) noexcept {
  double sum = 0.0;  // finite only if the forces are
  for (size_t e = b->begin; e < b->end; e++) {
    const Tetrahedron t(*b, e);
    const Mat3 f = t.deformation_gradient(at_corners(*b, e, b->x));
    Mat3 s = stress(law(p), f);
    if (law(p).viscosity_shear > 0.0)
      s = s + viscous_stress(law(p), f, t.deformation_gradient(at_corners(*b, e, b->v)));
    for (size_t a = 0; a < 4; a++) {
      const Vec3 force = -t.volume * (s * t.gradient[a]);
      double *node = out + 3 * size_t{b->elements[4 * e + a]};
      for (size_t i = 0; i < 3; i++) node[i] += force[i];
      if (a > 0) sum += force[a - 1];
    }
  }
  return check_finite(p, sum);
}

pliant_status tangent(const pliant_plugin *p, const pliant_batch *b, double stiffness, double damping,
                      const pliant_blocks *blocks) noexcept {
  for (size_t e = b->begin; e < b->end; e++) {
    const Tetrahedron t(*b, e);
    const Mat3 f = t.deformation_gradient(at_corners(*b, e, b->x));
    if (stiffness != 0.0) add_stiffness(law(p), t, f, stiffness, *blocks, 10 * e);
    if (damping != 0.0 && law(p).viscosity_shear > 0.0) add_damping(law(p), t, f, damping, *blocks, 10 * e);
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
  const bool is_index = param.kind != PLIANT_PARAM_CHOICE || value == std::floor(value);
  if (!(value >= param.min && value <= param.max && is_index)) {
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
  l.viscosity_shear = v[DAMPING_TIME] * l.mu;
  l.viscosity_dilatation = v[DAMPING_TIME] * l.lambda;
  l.project = v[TANGENT] == 0.0;
  return PLIANT_OK;
}

void deactivate(const pliant_plugin *) noexcept {}

const void *extension(const pliant_plugin *, const char *id) noexcept {
  return std::strcmp(id, PLIANT_MATERIAL) == 0 ? &material : nullptr;
}

}  // namespace

// The three functions of the library; src/lib.rs exports the table with them.
extern "C" pliant_status corotational_init(const pliant_host *, const char *) noexcept { return PLIANT_OK; }

extern "C" const pliant_descriptor *corotational_descriptor(uint32_t index) noexcept {
  return index == 0 ? &descriptor : nullptr;
}

extern "C" const pliant_plugin *corotational_create(const pliant_host *host, const char *id) noexcept {
  if (std::strcmp(id, descriptor.id) != 0) return nullptr;
  Instance *instance = new (std::nothrow) Instance{};
  if (!instance) return nullptr;
  instance->plugin = {sizeof(pliant_plugin), &descriptor, instance, destroy, set_number, set_text,
                      set_table, activate, deactivate, extension};
  instance->host = host;
  for (uint32_t i = 0; i < PARAMS; i++) instance->values[i] = params[i].fallback;
  return &instance->plugin;
}
