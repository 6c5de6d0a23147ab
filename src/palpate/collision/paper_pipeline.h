/// \file
/// Contact query as the paper describes it: the baseline for comparison.
#pragma once

#include <cstddef>
#include <memory>

#include <palpate/collision/contact.h>
#include <palpate/scene/scene_filter.h>

namespace palpate {

/// Paper III-B: a kd-tree over the *centres* searched with a fixed radius, the bounding-sphere
/// pre-filter of eq. 4, and a golden-section search with a fixed number of iterations for the
/// minimum of K. K itself is evaluated in the form of k_function.h, because eqs. 5-6 taken
/// literally are wrong for flat Gaussians; what is reproduced here is the pipeline.
///
/// Known limitations, which can_miss() counts and tests demonstrate: a Gaussian that is larger than the
/// search radius less the tool is not found when its centre is out of reach, and a minimum within golden
/// section's last bracket of lambda = 0 or 1 is not resolved.
class PaperPipeline final : public ContactQuery {
 public:
  static constexpr int kDefaultIterations = 30;  ///< the last bracket is 0.618^30 = 5e-7 wide

  /// \param search_radius of the kd-tree query around the tool centre. Unit: [m], positive.
  PaperPipeline(EllipsoidScene scene, double search_radius, int iterations = kDefaultIterations);
  ~PaperPipeline() override;

  void query(const Ellipsoid& tool, ContactSet& result) const override;

  double search_radius() const { return search_radius_; }

  /// Gaussians so large that a tool of bounding radius `tool_radius` can touch them while their
  /// centre lies outside the search radius: r_i + tool_radius > search_radius.
  std::size_t can_miss(double tool_radius) const;

  /// A radius that reaches all but the largest 1 % of the Gaussians of `scene`: their 99 % quantile
  /// radius plus `tool_radius`. The paper gives no figure. Unit: [m].
  static double default_search_radius(const EllipsoidScene& scene, double tool_radius);

 private:
  struct Tree;

  EllipsoidScene scene_;
  std::vector<double> radius_;  ///< r_i of eq. 4. Unit: [m].
  double search_radius_;
  int iterations_;
  std::unique_ptr<Tree> tree_;
};

}  // namespace palpate
