// A tetrahedron whose strain is measured in a frame that turns with it:
//
//   psi(F) = mu |F - R|^2 + lambda/2 tr(R^T F - 1)^2,  F = R S
//
// (Etzmuss, Keckeisen and Strasser 2003; Mueller and Gross 2004). The matrix is the whole second derivative, with the turning
// of the frame in it (Chao et al. 2010), in closed form, and without its negative part unless the exact one is asked for.
#pragma once
#include "matrix.hpp"
#include "pliant.h"

namespace corotational {

// Values of rest data of an element: the gradients of the last three corners' weights, then its volume.
constexpr uint32_t STRIDE = 10;

struct Law {
  double mu, lambda;   // Pa
  double density;      // kg/m^3
  double eta, zeta;    // Pa s, viscosity on the rate of Green's strain: shear and dilation
  bool project;
};

struct Tetrahedron {
  std::array<V3, 4> gradient;  // 1/m
  double volume;               // m^3

  static bool measure(const std::array<V3, 4> &x, double share, double *out, size_t count) {
    M3 edges;
    for (int a = 0; a < 3; a++)
      for (int i = 0; i < 3; i++) edges[a][i] = x[a + 1][i] - x[0][i];
    const double six = dot(edges[0], cross(edges[1], edges[2]));
    if (!(std::isfinite(six) && six > 0.0 && share > 0.0)) return false;
    const M3 g = {cross(edges[1], edges[2]), cross(edges[2], edges[0]), cross(edges[0], edges[1])};
    for (size_t s = 0; s < 9; s++) out[s * count] = g[s / 3][s % 3] / six;
    out[9 * count] = share * six / 6.0;
    return true;
  }

  Tetrahedron(const pliant_batch &b, size_t e) {
    const double *data = b.rest_data + e;
    for (size_t s = 0; s < 9; s++) gradient[1 + s / 3][s % 3] = data[s * b.count];
    for (int i = 0; i < 3; i++) gradient[0][i] = -(gradient[1][i] + gradient[2][i] + gradient[3][i]);
    volume = data[9 * b.count];
  }

  // Of positions the deformation gradient, of velocities its rate.
  M3 derivative(const std::array<V3, 4> &p) const {
    M3 f = {};
    for (int a = 1; a < 4; a++)
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) f[i][j] += (p[a][i] - p[0][i]) * gradient[a][j];
    return f;
  }
};

// The values of an element's corners.
inline std::array<V3, 4> corners(const pliant_batch &b, size_t e, const double *of) {
  std::array<V3, 4> p;
  for (size_t a = 0; a < 4; a++) {
    const double *at = of + 3 * size_t{b.elements[4 * e + a]};
    p[a] = {at[0], at[1], at[2]};
  }
  return p;
}

inline double energy(const Law &law, const M3 &f) {
  const Frame frame(f);
  const V3 strain = {frame.s[0] - 1.0, frame.s[1] - 1.0, frame.s[2] - 1.0};
  const double trace = strain[0] + strain[1] + strain[2];
  return law.mu * dot(strain, strain) + 0.5 * law.lambda * trace * trace;
}

// First Piola-Kirchhoff stress, Pa.
inline M3 stress(const Law &law, const M3 &f) {
  const Frame frame(f);
  const double pressure = law.lambda * (frame.s[0] + frame.s[1] + frame.s[2] - 3.0);
  M3 p;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) p[i][j] = 2.0 * law.mu * (f[i][j] - frame.r[i][j]) + pressure * frame.r[i][j];
  return p;
}

// Adds the stress of the viscosity: F (2 eta E' + zeta tr(E') 1), E' the rate of Green's strain.
inline void add_viscous_stress(const Law &law, const M3 &f, const M3 &rate, M3 &p) {
  const M3 ft = transposed(f), rt = transposed(rate);
  M3 strain;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) strain[i][j] = law.eta * (dot(ft[i], rt[j]) + dot(rt[i], ft[j]));
  const double pressure = law.zeta * (dot(ft[0], rt[0]) + dot(ft[1], rt[1]) + dot(ft[2], rt[2]));
  for (int i = 0; i < 3; i++) strain[i][i] += pressure;
  const M3 viscous = product(f, strain);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) p[i][j] += viscous[i][j];
}

// Adds the ten blocks of an element's stiffness, N/m.
inline void add_stiffness(const Law &law, const Tetrahedron &t, const M3 &f, double scale,
                          const pliant_blocks &to, size_t slot) {
  const Frame frame(f);
  const double turning = law.lambda * (frame.s[0] + frame.s[1] + frame.s[2] - 3.0) - 2.0 * law.mu;
  const double factor = scale * t.volume;
  M3 own = {}, other = {};  // of the entries (i, j) and (j, i) of dF in the frame: with itself, and with the other
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      if (i == j) continue;
      // Two opposite stretches make the frame turn without bound; there the exact matrix has a pole.
      const double sum = frame.s[i] + frame.s[j], least = law.project ? 1e-9 : 1e-300;
      double twist = 2.0 * (law.mu + turning / (std::fabs(sum) < least ? least : sum));
      if (law.project && twist < 0.0) twist = 0.0;
      own[i][j] = 0.5 * (2.0 * law.mu + twist);
      other[i][j] = 0.5 * (2.0 * law.mu - twist);
    }
  std::array<V3, 4> g;
  const M3 vt = transposed(frame.v);
  for (int a = 0; a < 4; a++) g[a] = times(vt, t.gradient[a]);
  for (int a = 0; a < 4; a++)
    for (int b = a; b < 4; b++, slot++) {
      M3 k = {};
      for (int i = 0; i < 3; i++) {
        k[i][i] += (2.0 * law.mu + law.lambda) * g[a][i] * g[b][i];
        for (int j = 0; j < 3; j++) {
          if (i == j) continue;
          k[i][j] += law.lambda * g[a][i] * g[b][j] + other[i][j] * g[a][j] * g[b][i];
          k[i][i] += own[i][j] * g[a][j] * g[b][j];
        }
      }
      const M3 turned = product(frame.u, product_transposed(k, frame.u));
      double block[9];
      for (int i = 0; i < 9; i++) block[i] = factor * turned[i / 3][i % 3];
      pliant_add_block(&to, slot, block);
    }
}

// Adds the ten blocks of its viscosity, N s/m.
inline void add_viscosity(const Law &law, const Tetrahedron &t, const M3 &f, double scale,
                          const pliant_blocks &to, size_t slot) {
  const double eta = scale * t.volume * law.eta, zeta = scale * t.volume * law.zeta;
  const M3 ff = product_transposed(f, f);
  std::array<V3, 4> fg;
  for (int a = 0; a < 4; a++) fg[a] = times(f, t.gradient[a]);
  for (int a = 0; a < 4; a++)
    for (int b = a; b < 4; b++, slot++) {
      const double gg = dot(t.gradient[a], t.gradient[b]);
      double block[9];
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          block[3 * i + j] = eta * (ff[i][j] * gg + fg[b][i] * fg[a][j]) + zeta * fg[a][i] * fg[b][j];
      pliant_add_block(&to, slot, block);
    }
}

}  // namespace corotational
