// Vectors, 3 x 3 matrices, and the rotation and singular values of a deformation gradient. Nothing allocates.
#pragma once
#include <cmath>
#include <cstddef>
#include <utility>

namespace corotational {

struct Vec3 {
  double component[3];
  double operator[](size_t axis) const { return component[axis]; }
  double &operator[](size_t axis) { return component[axis]; }
};

inline Vec3 operator+(const Vec3 &a, const Vec3 &b) { return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}}; }
inline Vec3 operator-(const Vec3 &a, const Vec3 &b) { return {{a[0] - b[0], a[1] - b[1], a[2] - b[2]}}; }
inline Vec3 operator-(const Vec3 &a) { return {{-a[0], -a[1], -a[2]}}; }
inline Vec3 operator*(double s, const Vec3 &a) { return {{s * a[0], s * a[1], s * a[2]}}; }

inline double dot(const Vec3 &a, const Vec3 &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline Vec3 cross(const Vec3 &a, const Vec3 &b) {
  return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}

inline double norm(const Vec3 &a) { return std::sqrt(dot(a, a)); }

// A matrix by rows: m[row][column].
struct Mat3 {
  Vec3 row[3];
  const Vec3 &operator[](size_t i) const { return row[i]; }
  Vec3 &operator[](size_t i) { return row[i]; }
};

inline Mat3 identity() { return {{{{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}}}; }

inline Mat3 operator+(const Mat3 &a, const Mat3 &b) { return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}}; }

inline Vec3 operator*(const Mat3 &m, const Vec3 &v) { return {{dot(m[0], v), dot(m[1], v), dot(m[2], v)}}; }

inline Mat3 transposed(const Mat3 &m) {
  return {{{{m[0][0], m[1][0], m[2][0]}}, {{m[0][1], m[1][1], m[2][1]}}, {{m[0][2], m[1][2], m[2][2]}}}};
}

// a b^T
inline Mat3 product_transposed(const Mat3 &a, const Mat3 &b) { return {{b * a[0], b * a[1], b * a[2]}}; }

inline Mat3 operator*(const Mat3 &a, const Mat3 &b) { return product_transposed(a, transposed(b)); }

// Eigenvectors of a symmetric matrix as the columns of a rotation (Jacobi 1846). `a` becomes diagonal.
inline Mat3 eigenvectors(Mat3 &a) {
  const int max_sweeps = 10;       // it converges quadratically, five are enough; the bound ends the loop for NaN
  const double converged = 1e-32;  // squares of the off-diagonal entries over those of all entries
  Mat3 v = identity();
  const double norm_squared = dot(a[0], a[0]) + dot(a[1], a[1]) + dot(a[2], a[2]);
  for (int sweep = 0; sweep < max_sweeps; sweep++) {
    if (a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2] <= converged * norm_squared) break;
    for (int r = 2; r >= 0; r--) {  // the axis that is not rotated
      const int p = r == 0 ? 1 : 0, q = r == 2 ? 1 : 2;
      const double apq = a[p][q];
      if (apq == 0.0) continue;
      const double theta = 0.5 * (a[q][q] - a[p][p]) / apq;
      const double t = std::copysign(1.0, theta) / (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
      const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
      const double arp = a[r][p], arq = a[r][q];
      a[p][p] -= t * apq;
      a[q][q] += t * apq;
      a[p][q] = a[q][p] = 0.0;
      a[r][p] = a[p][r] = c * arp - s * arq;
      a[r][q] = a[q][r] = s * arp + c * arq;
      for (Vec3 &row : v.row) {
        const double x = row[p], y = row[q];
        row[p] = c * x - s * y;
        row[q] = s * x + c * y;
      }
    }
  }
  return v;
}

// The axis a vector has the smallest component along.
inline Vec3 smallest_axis(const Vec3 &a) {
  const double x = std::fabs(a[0]), y = std::fabs(a[1]), z = std::fabs(a[2]);
  if (x <= y && x <= z) return {{1, 0, 0}};
  if (y <= z) return {{0, 1, 0}};
  return {{0, 0, 1}};
}

// F = U diag(s) V^T and R = U V^T with rotations U, V and R. The last singular value has the sign of det F, so that R is a rotation even of
// a flat or inverted element (Irving, Teran and Fedkiw 2004).
struct SingularValues {
  Mat3 u, v, r;
  Vec3 s;

  explicit SingularValues(const Mat3 &f) {
    const double rank_one = 1e-14;  // second over first singular value below which F counts as of rank one
    const Mat3 f_columns = transposed(f);
    Mat3 square = product_transposed(f_columns, f_columns);
    const Mat3 directions = transposed(eigenvectors(square));
    int order[3] = {0, 1, 2};
    const auto sort_pair = [&](int i, int j) {
      if (square[order[i]][order[i]] < square[order[j]][order[j]]) std::swap(order[i], order[j]);
    };
    sort_pair(0, 1);
    sort_pair(1, 2);
    sort_pair(0, 1);
    const Vec3 v0 = directions[order[0]], v1 = directions[order[1]], v2 = cross(v0, v1);
    v = transposed({{v0, v1, v2}});
    Vec3 u0 = f * v0;
    s[0] = norm(u0);
    if (s[0] == 0.0) {  // the element has collapsed to a point
      u = r = v = identity();
      s = {{0, 0, 0}};
      return;
    }
    u0 = (1.0 / s[0]) * u0;
    const Vec3 second = f * v1;
    Vec3 u1 = second - dot(second, u0) * u0;
    double length = norm(u1);
    if (length <= rank_one * s[0]) {  // collapsed to a line: any perpendicular direction will do
      u1 = cross(u0, smallest_axis(u0));
      length = norm(u1);
    }
    u1 = (1.0 / length) * u1;
    const Vec3 u2 = cross(u0, u1);
    s[1] = dot(u1, second);
    s[2] = dot(u2, f * v2);
    u = transposed({{u0, u1, u2}});
    r = product_transposed(u, v);
  }
};

// The rotation R of F = R S by Newton's iteration R <- (R + R^-T) / 2 (Higham 1986), in five steps at strains of a third and at a quarter of the cost of
// singular values. Those are taken where F is nearly flat or inverted, or so large or small that eight steps are not enough.
inline Mat3 rotation(const Mat3 &f) {
  const int max_steps = 8;
  const double converged = 1e-16;  // square of the last change: half of it is left, which is below rounding
  const double flat = 1e-4;        // square of det F over the cube of |F|^2, which is 1/27 for a rotation
  Mat3 r = f;
  for (int step = 0; step < max_steps; step++) {
    const Mat3 cofactors = {{cross(r[1], r[2]), cross(r[2], r[0]), cross(r[0], r[1])}};
    const double determinant = dot(r[0], cofactors[0]);
    if (step == 0) {
      const double norm_squared = dot(f[0], f[0]) + dot(f[1], f[1]) + dot(f[2], f[2]);
      if (!(determinant > 0.0 && determinant * determinant > flat * norm_squared * norm_squared * norm_squared)) break;
    }
    const double half_inverse = 0.5 / determinant;
    double change = 0.0;
    for (size_t i = 0; i < 3; i++) {
      const Vec3 next = 0.5 * r[i] + half_inverse * cofactors[i], difference = next - r[i];
      change += dot(difference, difference);
      r[i] = next;
    }
    if (change <= converged) return r;
  }
  return SingularValues(f).r;
}

}  // namespace corotational
