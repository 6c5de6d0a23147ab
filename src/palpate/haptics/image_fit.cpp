#include <palpate/haptics/image_fit.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Priors that slope and curvature are zero: weights as fractions of all rays, at a distance of one detail.
constexpr double kSlopePrior = 5e-4, kCurvaturePrior = 1e-3, kSaddlePrior = 5e-2;
/// Number of fits; each gives less weight to hits far from the one before.
constexpr int kFits = 3;
/// Distance at which a hit counts half: kFirstSpread from the first fit; from later ones, kFar times the
/// roughness, at least kLeastSpread. In details.
constexpr double kFirstSpread = 1.0, kLeastSpread = 0.15, kFar = 2.0;

}  // namespace

Vector2d image_of(const ViewFrame& view, const Vector3d& point) {
  const Vector3d from = point - view.origin;
  return {from.dot(view.u), from.dot(view.v)};
}

Vector2d towards(const Vector2d& from, const Vector2d& to, double most) {
  const Vector2d way = to - from;
  const double length = way.norm();
  return length <= most ? to : Vector2d(from + most / length * way);
}

double depth_of(const Profile& profile, const Vector2d& place) {
  return static_cast<double>(profile.depth(static_cast<float>(place.x()), static_cast<float>(place.y())));
}

bool is_below(const Profile& profile, const Vector2d& place) {
  return profile.below(static_cast<float>(place.x()), static_cast<float>(place.y()));
}

double start_of(const Profile& profile, const Vector2d& place) {
  const double half = std::sqrt(
      std::max(0.0, 1.0 - (place.x() * place.x() * profile.aa + 2.0 * place.x() * place.y() * profile.ab +
                           place.y() * place.y() * profile.bb) /
                              profile.cc) /
      profile.cc);
  return depth_of(profile, place) - 1.5 * half;
}

// The minimum of (x, y) m - half(x, y) / 2 over the silhouette, with m the slope of the chords' midpoints, is
// -sqrt(M^2 + H^2 / 4), with M the largest midpoint, H the longest half chord, and M^2 + H^2 the square of
// the solid's reach.
double start_of_all(const Profile& profile, const Ellipsoid& solid, const Vector3d& along) {
  const double reach_squared = (solid.axes.transpose() * along).squaredNorm();
  return -std::sqrt(std::max(0.0, reach_squared - 0.75 / static_cast<double>(profile.cc)));
}

Vector3d inward_normal(const Ellipsoid& solid, const Vector3d& point) {
  const Vector3d from = solid.center - point;
  Vector3d normal = Vector3d::Zero();
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double squared = solid.axes.col(k).squaredNorm();
    normal += solid.axes.col(k) * (solid.axes.col(k).dot(from) / (squared * squared));
  }
  return normal.normalized();
}

ToolSide::ToolSide(const Profile& p, const Vector2d& place) {
  Matrix2d form;
  form << p.aa, p.ab, p.ab, p.bb;
  const Vector2d of = form * place;
  const double facing = p.cc - place.dot(of), root = std::sqrt(facing);
  slope = -(of / root + Vector2d(p.d, p.e)) / p.cc;
  curvature = (form + of * of.transpose() / facing) / (root * p.cc);
}

Matrix2d ToolSide::more_than_tool(const Matrix2d& bend) const {
  const double mean = 0.5 * curvature.trace();
  const double least = mean - std::sqrt(std::max(0.0, mean * mean - curvature.determinant()));
  const Eigen::SelfAdjointEigenSolver<Matrix2d> axes(bend);
  const Vector2d more = (axes.eigenvalues().array() - least).max(0.0);
  return axes.eigenvectors() * more.asDiagonal() * axes.eigenvectors().transpose();
}

Vector2d ToolSide::to_least(const Vector2d& surface, const Matrix2d& bend) const {
  return (curvature + bend).inverse() * (slope - surface);
}

ImageFit::Terms ImageFit::solve(const DepthMoments& moments) {
  Eigen::Matrix<double, DepthMoments::kTerms, DepthMoments::kTerms> matrix;
  std::size_t at = 0;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = i; j < matrix.cols(); ++j)
      matrix(i, j) = matrix(j, i) = moments.normal_matrix[at++];
  Terms priors;
  priors << 0.0, kSlopePrior, kSlopePrior, kCurvaturePrior, kSaddlePrior, kSaddlePrior;
  matrix.diagonal() += static_cast<double>(moments.aimed) * priors;
  return matrix.ldlt().solve(
      Eigen::Map<const Eigen::Matrix<float, DepthMoments::kTerms, 1>>(moments.right.data()).cast<double>());
}

bool ImageFit::to(const DepthView& image, const Window& window) {
  constexpr float kAnything = 1e-3F;
  window_ = window;
  DepthKernel kernel{
      window.center, window.detail, window.level, window.radius, {}, static_cast<float>(kFirstSpread)};
  for (int k = 0; k < kFits; ++k) {
    moments_ = image.moments(kernel);
    if (!(moments_.hit > kAnything * moments_.aimed)) return false;
    of_ = solve(moments_);
    Eigen::Map<Eigen::Matrix<float, DepthMoments::kTerms, 1>>(kernel.fit.data()) = of_.cast<float>();
    if (k > 0)
      kernel.spread = static_cast<float>(
          std::max(kLeastSpread, kFar * std::sqrt(static_cast<double>(moments_.residual / moments_.hit))));
    else
      kernel.spread = static_cast<float>(0.5 * kFirstSpread);
  }
  return true;
}

double ImageFit::depth(const Vector2d& place) const {
  const Vector2d u = (place - window_.center) / window_.detail;
  Terms terms;
  terms << 1.0, u.x(), u.y(), u.squaredNorm(), u.x() * u.x() - u.y() * u.y(), 2.0 * u.x() * u.y();
  return window_.level + window_.detail * of_.dot(terms);
}

double ImageFit::roughness() const {
  return window_.detail *
         std::sqrt(static_cast<double>(moments_.residual) / static_cast<double>(moments_.hit));
}

Matrix2d ImageFit::bend() const {
  Matrix2d hessian;
  hessian << of_[3] + of_[4], of_[5], of_[5], of_[3] - of_[4];
  return 2.0 / window_.detail * hessian;
}

}  // namespace palpate
