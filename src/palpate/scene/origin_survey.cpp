#include <palpate/scene/origin_survey.h>

#include <cmath>

#include <palpate/base/quantile.h>
#include <palpate/scene/gaussian_scene.h>

namespace palpate {
namespace {

std::uint64_t ratio_up(std::uint64_t a, std::uint64_t b) { return (a + b - 1) / b; }

bool is_exact(const Eigen::Vector3d& p) { return !p.allFinite() || p.cast<float>().cast<double>() == p; }

}  // namespace

OriginSurvey::OriginSurvey(std::uint64_t count)
    : every_(ratio_up(count, kMaxSample)), sample_(ratio_up(count, every_)) {}

void OriginSurvey::add(std::uint64_t row, const Eigen::Vector3d& position) {
  // Read before it is written: threads that all write would contend for it in every row.
  if (exact_.load(std::memory_order_relaxed) && !is_exact(position))
    exact_.store(false, std::memory_order_relaxed);
  if (row % every_ == 0) sample_[row / every_] = position;
}

Eigen::Vector3d OriginSurvey::origin() const {
  Eigen::Vector3d result = Eigen::Vector3d::Zero();
  if (exact_) return result;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    values.reserve(sample_.size());
    for (const Eigen::Vector3d& p : sample_) {
      if (std::abs(p[axis]) <= kMaxExtent) values.push_back(p[axis]);
    }
    result[axis] = std::round(quantile(values, 0.5));
  }
  return result;
}

}  // namespace palpate
