// A tetrahedron whose strain is measured in a frame that rotates with it:
//
//   psi(F) = mu |F - R|^2 + lambda/2 tr(R^T F - 1)^2,  F = R S
//
// (Etzmuss, Keckeisen and Strasser 2003; Mueller and Gross 2004). The matrix is the complete second derivative in closed form, with the
// derivative of the rotation (Chao et al. 2010), made positive semi-definite unless the exact one is asked for.
#pragma once
#include "matrix.hpp"
#include "pliant.h"

#include <array>

namespace corotational {

// Doubles of rest data per element: the shape function gradients of the last three corners (1/m), then the volume (m^3).
constexpr uint32_t STRIDE = 10;

struct Law {
  double mu, lambda;                                // Lame constants, Pa
  double density;                                   // kg/m^3
  double viscosity_shear, viscosity_dilatation;     // Pa s, on the rate of Green's strain
  bool project;                                     // whether the matrix is made positive semi-definite
};

using Corners = std::array<Vec3, 4>;

// The rest shape of an element.
struct Tetrahedron {
  Corners gradient;  // of each corner's shape function, 1/m
  double volume;     // m^3

  // Writes rest data with a distance of `count` between values, from rest positions (m) and the share of the volume that belongs to the
  // body; false where the volume is not positive.
  static bool write_rest_data(const Corners &x, double share, double *out, size_t count) {
    const Vec3 a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
    const double six_volumes = dot(a, cross(b, c));
    if (!(std::isfinite(six_volumes) && six_volumes > 0.0 && share > 0.0)) return false;
    const Mat3 cofactors = {{cross(b, c), cross(c, a), cross(a, b)}};
    for (size_t s = 0; s < 9; s++) out[s * count] = cofactors[s / 3][s % 3] / six_volumes;
    out[9 * count] = share * six_volumes / 6.0;
    return true;
  }

  // Element `e` of a batch, from its rest data.
  Tetrahedron(const pliant_batch &batch, size_t e) {
    const double *data = batch.rest_data + e;
    for (size_t s = 0; s < 9; s++) gradient[1 + s / 3][s % 3] = data[s * batch.count];
    gradient[0] = -(gradient[1] + gradient[2] + gradient[3]);
    volume = data[9 * batch.count];
  }

  // sum_a p_a gradient_a^T: the deformation gradient F from positions, or its rate from velocities.
  Mat3 deformation_gradient(const Corners &p) const {
    Mat3 f = {};
    for (size_t a = 1; a < 4; a++) {
      const Vec3 edge = p[a] - p[0];
      for (size_t i = 0; i < 3; i++)
        for (size_t j = 0; j < 3; j++) f[i][j] += edge[i] * gradient[a][j];
    }
    return f;
  }
};

// Vectors (n x 3) at the corners of element `e`.
inline Corners at_corners(const pliant_batch &batch, size_t e, const double *vectors) {
  Corners corners;
  for (size_t a = 0; a < 4; a++) {
    const double *v = vectors + 3 * size_t{batch.elements[4 * e + a]};
    corners[a] = {{v[0], v[1], v[2]}};
  }
  return corners;
}

// tr(R^T F), the sum of the singular values.
inline double sum_of_stretches(const Mat3 &f, const Mat3 &r) { return dot(r[0], f[0]) + dot(r[1], f[1]) + dot(r[2], f[2]); }

// Energy density, J/m^3.
inline double energy(const Law &law, const Mat3 &f) {
  const Mat3 r = rotation(f);
  double squares = 0.0;
  for (size_t i = 0; i < 3; i++) squares += dot(f[i] - r[i], f[i] - r[i]);
  const double trace = sum_of_stretches(f, r) - 3.0;
  return law.mu * squares + 0.5 * law.lambda * trace * trace;
}

// First Piola-Kirchhoff stress, Pa.
inline Mat3 stress(const Law &law, const Mat3 &f) {
  const Mat3 r = rotation(f);
  const double pressure = law.lambda * (sum_of_stretches(f, r) - 3.0);
  Mat3 p;
  for (size_t i = 0; i < 3; i++) p[i] = 2.0 * law.mu * (f[i] - r[i]) + pressure * r[i];
  return p;
}

// Viscous first Piola-Kirchhoff stress, Pa: F (2 eta E' + zeta tr(E') 1), with E' the rate of Green's strain and eta, zeta the
// coefficients of shear and dilatation.
inline Mat3 viscous_stress(const Law &law, const Mat3 &f, const Mat3 &f_rate) {
  const Mat3 columns = transposed(f), rates = transposed(f_rate);
  Mat3 second;
  for (size_t i = 0; i < 3; i++)
    for (size_t j = 0; j < 3; j++)
      second[i][j] = law.viscosity_shear * (dot(columns[i], rates[j]) + dot(rates[i], columns[j]));
  const double trace = dot(columns[0], rates[0]) + dot(columns[1], rates[1]) + dot(columns[2], rates[2]);
  for (size_t i = 0; i < 3; i++) second[i][i] += law.viscosity_dilatation * trace;
  return f * second;
}

// Adds `scale` times the ten stiffness blocks of an element, N/m; `slot` is the index of its first slot.
inline void add_stiffness(const Law &law, const Tetrahedron &t, const Mat3 &f, double scale, const pliant_blocks &out,
                          size_t slot) {
  const SingularValues singular(f);
  const double rotation_term = law.lambda * (singular.s[0] + singular.s[1] + singular.s[2] - 3.0) - 2.0 * law.mu;
  const double factor = scale * t.volume;
  // Of the off-diagonal entries (i, j) and (j, i) of U^T dF V: stiffness of an entry with itself, and with the other.
  Mat3 own = {}, cross_term = {};
  for (size_t i = 0; i < 3; i++)
    for (size_t j = 0; j < 3; j++) {
      if (i == j) continue;
      // Where two singular values are opposite, R is not unique and the exact matrix has a pole.
      const double sum = singular.s[i] + singular.s[j], least = law.project ? 1e-9 : 1e-300;
      double antisymmetric = 2.0 * (law.mu + rotation_term / (std::fabs(sum) < least ? least : sum));
      if (law.project && antisymmetric < 0.0) antisymmetric = 0.0;
      own[i][j] = 0.5 * (2.0 * law.mu + antisymmetric);
      cross_term[i][j] = 0.5 * (2.0 * law.mu - antisymmetric);
    }
  Corners g;  // shape function gradients in the frame of V
  const Mat3 vt = transposed(singular.v);
  for (size_t a = 0; a < 4; a++) g[a] = vt * t.gradient[a];
  for (size_t a = 0; a < 4; a++)
    for (size_t b = a; b < 4; b++, slot++) {
      Mat3 k = {};
      for (size_t i = 0; i < 3; i++) {
        k[i][i] += (2.0 * law.mu + law.lambda) * g[a][i] * g[b][i];
        for (size_t j = 0; j < 3; j++) {
          if (i == j) continue;
          k[i][j] += law.lambda * g[a][i] * g[b][j] + cross_term[i][j] * g[a][j] * g[b][i];
          k[i][i] += own[i][j] * g[a][j] * g[b][j];
        }
      }
      const Mat3 in_space = singular.u * product_transposed(k, singular.u);
      double block[9];
      for (size_t i = 0; i < 9; i++) block[i] = factor * in_space[i / 3][i % 3];
      pliant_add_block(&out, slot, block);
    }
}

// Adds `scale` times the ten damping blocks of an element, N s/m; `slot` is the index of its first slot.
inline void add_damping(const Law &law, const Tetrahedron &t, const Mat3 &f, double scale, const pliant_blocks &out,
                        size_t slot) {
  const double eta = scale * t.volume * law.viscosity_shear, zeta = scale * t.volume * law.viscosity_dilatation;
  const Mat3 f_ft = product_transposed(f, f);
  Corners fg;  // F times the shape function gradients
  for (size_t a = 0; a < 4; a++) fg[a] = f * t.gradient[a];
  for (size_t a = 0; a < 4; a++)
    for (size_t b = a; b < 4; b++, slot++) {
      const double gradients = dot(t.gradient[a], t.gradient[b]);
      double block[9];
      for (size_t i = 0; i < 3; i++)
        for (size_t j = 0; j < 3; j++)
          block[3 * i + j] = eta * (f_ft[i][j] * gradients + fg[b][i] * fg[a][j]) + zeta * fg[a][i] * fg[b][j];
      pliant_add_block(&out, slot, block);
    }
}

}  // namespace corotational
