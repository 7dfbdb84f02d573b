// The run in C++ with Eigen: fixed sizes, no allocation, RK4 over the flat state y = [q; dq; W row by row].
// g++ -O3 -march=native $(pkg-config --cflags eigen3) closed_loop.cpp && ./a.out [runs before the timed one]
#include <Eigen/Dense>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kSets = 5, kRules = 625, kSteps = 20000;
constexpr double kStep = 1e-3, kKp = 8.0, kKv = 5.5, kGain = 7000.0;
constexpr double kP12 = 0.6515307716504657, kP22 = 1.147191888366882;

using State = Eigen::Matrix<double, 4 + 2 * kRules, 1>;
using Basis = Eigen::Matrix<double, kRules, 1>;
using Weights = Eigen::Matrix<double, 2, kRules, Eigen::RowMajor>;
using Sets = Eigen::Array<double, kSets, 1>;

struct Setpoint {
  Vector2d q, dq, ddq;
};

static Setpoint desired(double t) {
  const double s1 = std::sin(t), c1 = std::cos(t), s3 = std::sin(3 * t), c3 = std::cos(3 * t);
  return {{0.5 * c1 + 0.2 * s3, -0.2 * s1 - 0.5 * c1},
          {-0.5 * s1 + 0.6 * c3, -0.2 * c1 + 0.5 * s1},
          {-0.5 * c1 - 1.8 * s3, 0.2 * s1 + 0.5 * c1}};
}

struct Arm {
  double theta1, theta2, theta3;

  Matrix2d mass(double c) const {
    const double m12 = theta3 + theta2 * c;
    return (Matrix2d() << theta1 + theta3 + 2 * theta2 * c, m12, m12, theta3).finished();
  }

  Vector2d bias(double s, const Vector2d& dq) const {
    return theta2 * s * Vector2d(-(2 * dq[0] + dq[1]) * dq[1], dq[0] * dq[0]);
  }
};

static const Arm kNominal{1.45, 0.5, 0.45}, kActual{2.9, 1.0, 0.9};

static Sets memberships(double x) {
  static const Sets centers = (Sets() << -1.5, -0.5, 0.0, 0.5, 1.5).finished();
  const Sets mu = (-(x - centers).square()).exp();
  return mu / mu.sum();
}

static void basis(const Vector2d& e, const Vector2d& de, Basis& xi) {
  const Sets p[4] = {memberships(e[0]), memberships(e[1]), memberships(de[0]), memberships(de[1])};
  Eigen::Matrix<double, kSets * kSets, 1> inner;
  for (int c = 0; c < kSets; ++c) inner.segment<kSets>(c * kSets) = (p[2][c] * p[3]).matrix();
  for (int a = 0; a < kSets; ++a)
    for (int b = 0; b < kSets; ++b)
      xi.segment<kSets * kSets>((a * kSets + b) * kSets * kSets) = (p[0][a] * p[1][b]) * inner;
}

static void rhs(double t, const State& y, State& dy) {
  const Vector2d q = y.head<2>(), dq = y.segment<2>(2);
  const Eigen::Map<const Weights> w(y.data() + 4);
  const Setpoint d = desired(t);
  const Vector2d e = q - d.q, de = dq - d.dq;
  Basis xi;
  basis(e, de, xi);

  const double s = std::sin(q[1]), c = std::cos(q[1]);
  const Vector2d v = d.ddq - kKv * de - kKp * e;
  const Vector2d tau = kNominal.mass(c) * (v - w * xi) + kNominal.bias(s, dq);
  const Vector2d net = tau - kActual.bias(s, dq) - Vector2d(std::sin(t), std::cos(t));

  dy.head<2>() = dq;
  dy.segment<2>(2).noalias() = kActual.mass(c).inverse() * net;
  Eigen::Map<Weights>(dy.data() + 4).noalias() = kGain * (kP12 * e + kP22 * de) * xi.transpose();
}

int main(int argc, char** argv) {
  static State y, at, k1, k2, k3, k4;
  const int warm = argc > 1 ? std::atoi(argv[1]) : 1;
  Vector2d squares;
  double seconds = 0, cpu = 0;
  for (int run = 0; run <= warm; ++run) {
    const std::clock_t cpu_begin = std::clock();
    const auto begin = std::chrono::steady_clock::now();
    y.setZero();
    y.head<2>() << 0.5, -0.5;
    squares.setZero();
    for (int k = 0; k < kSteps; ++k) {
      const double t = k * kStep;
      rhs(t, y, k1);
      at = y + kStep / 2 * k1;
      rhs(t + kStep / 2, at, k2);
      at = y + kStep / 2 * k2;
      rhs(t + kStep / 2, at, k3);
      at = y + kStep * k3;
      rhs(t + kStep, at, k4);
      y += kStep / 6 * (k1 + 2 * (k2 + k3) + k4);
      squares += (y.head<2>() - desired(t + kStep).q).cwiseAbs2();
    }
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    seconds = took.count();
    cpu = double(std::clock() - cpu_begin) / CLOCKS_PER_SEC;
  }
  const Vector2d rms = (squares / kSteps).cwiseSqrt();
  std::printf("{\"peer\": \"eigen\", \"seconds\": %.6f, \"cpu\": %.6f, \"rms\": [%.12f, %.12f]}\n",
              seconds, cpu, rms[0], rms[1]);
}
