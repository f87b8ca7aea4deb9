// 3 x 3 matrices, and the frame of a deformation. Nothing allocates.
#pragma once
#include <array>
#include <cmath>

namespace corotational {

using V3 = std::array<double, 3>;
using M3 = std::array<V3, 3>;  // m[row][column]

inline double dot(const V3 &a, const V3 &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline V3 cross(const V3 &a, const V3 &b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline V3 scaled(double s, const V3 &v) { return {s * v[0], s * v[1], s * v[2]}; }

inline V3 times(const M3 &m, const V3 &v) { return {dot(m[0], v), dot(m[1], v), dot(m[2], v)}; }

inline M3 transposed(const M3 &m) {
  return {V3{m[0][0], m[1][0], m[2][0]}, V3{m[0][1], m[1][1], m[2][1]}, V3{m[0][2], m[1][2], m[2][2]}};
}

// a b^T
inline M3 product_transposed(const M3 &a, const M3 &b) {
  return {V3{dot(a[0], b[0]), dot(a[0], b[1]), dot(a[0], b[2])},
          V3{dot(a[1], b[0]), dot(a[1], b[1]), dot(a[1], b[2])},
          V3{dot(a[2], b[0]), dot(a[2], b[1]), dot(a[2], b[2])}};
}

inline M3 product(const M3 &a, const M3 &b) { return product_transposed(a, transposed(b)); }

// Eigenvectors of a symmetric matrix as columns of a rotation (Jacobi 1846); a becomes diagonal.
inline M3 eigenvectors(M3 &a) {
  M3 v = {V3{1, 0, 0}, V3{0, 1, 0}, V3{0, 0, 1}};
  const double size = dot(a[0], a[0]) + dot(a[1], a[1]) + dot(a[2], a[2]);
  for (int sweep = 0; sweep < 10; sweep++) {  // five are plenty, and a matrix of NaN must end too
    if (a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2] <= 1e-32 * size) break;
    for (int r = 2; r >= 0; r--) {
      const int p = r == 0 ? 1 : 0, q = r == 2 ? 1 : 2;
      const double off = a[p][q];
      if (off == 0.0) continue;
      const double theta = 0.5 * (a[q][q] - a[p][p]) / off;
      const double t = std::copysign(1.0, theta) / (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
      const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
      const double rp = a[r][p], rq = a[r][q];
      a[p][p] -= t * off;
      a[q][q] += t * off;
      a[p][q] = a[q][p] = 0.0;
      a[r][p] = a[p][r] = c * rp - s * rq;
      a[r][q] = a[q][r] = s * rp + c * rq;
      for (V3 &row : v) {
        const double x = row[p], y = row[q];
        row[p] = c * x - s * y;
        row[q] = s * x + c * y;
      }
    }
  }
  return v;
}

// F = U diag(s) V^T with U and V rotations: the least of s has the sign of det F, so that R = U V^T is a rotation even of
// an element that is flat or inside out (Irving, Teran and Fedkiw 2004).
struct Frame {
  M3 u, v, r;
  V3 s;

  explicit Frame(const M3 &f) {
    const M3 back = transposed(f);
    M3 square = product_transposed(back, back);
    const M3 columns = transposed(eigenvectors(square));
    int first = 0, second = 1, third = 2;
    const auto value = [&](int i) { return square[i][i]; };
    const auto order = [&](int &a, int &b) { if (value(a) < value(b)) { const int c = a; a = b; b = c; } };
    order(first, second);
    order(second, third);
    order(first, second);
    const V3 v0 = columns[first], v1 = columns[second], v2 = cross(v0, v1);
    v = transposed({v0, v1, v2});
    V3 u0 = times(f, v0);
    s[0] = std::sqrt(dot(u0, u0));
    if (s[0] == 0.0) {  // collapsed to a point
      u = r = v = {V3{1, 0, 0}, V3{0, 1, 0}, V3{0, 0, 1}};
      s = {0, 0, 0};
      return;
    }
    u0 = scaled(1.0 / s[0], u0);
    const V3 w = times(f, v1);
    const double along = dot(w, u0);
    V3 u1 = {w[0] - along * u0[0], w[1] - along * u0[1], w[2] - along * u0[2]};
    double left = std::sqrt(dot(u1, u1));
    if (left <= 1e-14 * s[0]) {  // to a line: any direction across it will do
      const double x = std::fabs(u0[0]), y = std::fabs(u0[1]), z = std::fabs(u0[2]);
      u1 = cross(u0, x <= y && x <= z ? V3{1, 0, 0} : y <= z ? V3{0, 1, 0} : V3{0, 0, 1});
      left = std::sqrt(dot(u1, u1));
    }
    u1 = scaled(1.0 / left, u1);
    const V3 u2 = cross(u0, u1);
    s[1] = dot(u1, w);
    s[2] = dot(u2, times(f, v2));
    u = transposed({u0, u1, u2});
    r = product_transposed(u, v);
  }
};

}  // namespace corotational
