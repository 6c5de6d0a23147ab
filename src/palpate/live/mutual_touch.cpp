#include <palpate/live/mutual_touch.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include <palpate/collision/k_function.h>

namespace palpate {
namespace {

double in_series(double a, double b) { return a + b > 0.0 ? a * b / (a + b) : 0.0; }

bool may_meet(const Eigen::Vector3d& a, double radius_a, const Eigen::Vector3d& b, double radius_b) {
  const double reach = radius_a + radius_b;
  return (a - b).squaredNorm() <= reach * reach;
}

/// Centre of a part in the world for the tool at `X_WT`.
Eigen::Vector3d place(const Pose& X_WT, const ToolPart& part) {
  return X_WT.position + X_WT.orientation * part.pose.position;
}

/// Two parts, by number, whose bounding spheres overlap.
struct NearPair {
  std::size_t low, high;
  double overlap;  ///< of the spheres. Unit: [m].

  bool comes_before(const NearPair& other) const {
    return low != other.low ? low < other.low : high < other.high;
  }
  /// A total order, so that both hands choose the same pairs.
  bool is_nearer(const NearPair& other) const {
    return overlap != other.overlap ? overlap > other.overlap : comes_before(other);
  }
};

/// The pairs of parts of two tools whose bounding spheres overlap, at most MutualTouch::kMostPairs: those
/// that overlap most. A pair costs a few nanoseconds here, and a hundred times that where it is examined.
class NearPairs {
 public:
  using Parts = std::span<const ToolPart>;

  void find(Parts low, const Pose& at_low, double radius_low, Parts high, const Pose& at_high,
            double radius_high) {
    for (std::size_t first = 0; first < high.size(); first += kBlock) {
      std::size_t count = 0;
      for (std::size_t k = first; k < std::min(first + kBlock, high.size()); ++k) {
        const Sphere sphere{place(at_high, high[k]), high[k].semi_axes.maxCoeff(), k};
        if (may_meet(sphere.center, sphere.radius, at_low.position, radius_low)) block_[count++] = sphere;
      }
      for (std::size_t k = 0; k < low.size(); ++k) {
        const Eigen::Vector3d center = place(at_low, low[k]);
        const double radius = low[k].semi_axes.maxCoeff();
        if (!may_meet(center, radius, at_high.position, radius_high)) continue;
        for (const Sphere& other : std::span(block_.data(), count)) {
          const double reach = radius + other.radius, squared = (center - other.center).squaredNorm();
          if (squared <= reach * reach) take({k, other.part, reach - std::sqrt(squared)});
        }
      }
    }
    // The order of the sum.
    std::sort(pairs_.begin(), pairs_.begin() + count_,
              [](const NearPair& a, const NearPair& b) { return a.comes_before(b); });
  }

  std::span<const NearPair> pairs() const { return {pairs_.data(), count_}; }
  bool are_all() const { return all_; }

 private:
  static constexpr std::size_t kBlock = 256;

  struct Sphere {
    Eigen::Vector3d center;
    double radius;
    std::size_t part;
  };

  /// Keeps a heap with the least near pair on top, once all places are taken.
  void take(const NearPair& pair) {
    const auto nearer = [](const NearPair& a, const NearPair& b) { return a.is_nearer(b); };
    if (count_ < pairs_.size()) {
      pairs_[count_++] = pair;
      if (count_ == pairs_.size()) std::make_heap(pairs_.begin(), pairs_.end(), nearer);
      return;
    }
    all_ = false;
    if (!pair.is_nearer(pairs_.front())) return;
    std::pop_heap(pairs_.begin(), pairs_.end(), nearer);
    pairs_.back() = pair;
    std::push_heap(pairs_.begin(), pairs_.end(), nearer);
  }

  std::array<Sphere, kBlock> block_;
  std::array<NearPair, MutualTouch::kMostPairs> pairs_;
  std::size_t count_ = 0;
  bool all_ = true;
};

}  // namespace

/// A force model with the forces from the other hands added.
class MutualTouch::Touching final : public ForceModel {
 public:
  Touching(MutualTouch& all, std::size_t hand, ForceModel& model, const Tool& tool, double stiffness)
      : all_(all), hand_(hand), model_(model) {
    own_.tool = &tool;
    own_.radius = tool.radius();
    own_.stiffness = stiffness;
  }

  bool wants_contacts() const override { return model_.wants_contacts(); }
  void reset() override {
    model_.reset();
    all_.leave(hand_);
  }
  ForceOutput evaluate(const ForceInput& input) override {
    ForceOutput felt = model_.evaluate(input);
    if (input.force_scale == 0.0) {
      all_.leave(hand_);
      return felt;
    }
    own_.pose = input.tool;
    own_.force_scale = input.force_scale;
    all_.enter(hand_, own_);
    all_.push(hand_, own_, felt);
    return felt;
  }

 private:
  MutualTouch& all_;
  std::size_t hand_;
  ForceModel& model_;
  Place own_;
};

MutualTouch::MutualTouch(std::size_t hands)
    : hands_(hands), links_(new Link[hands * hands]), presence_(hands), is_there_(hands) {}

std::unique_ptr<ForceModel> MutualTouch::around(std::size_t hand, ForceModel& model, const Tool& tool,
                                                double stiffness) {
  return std::make_unique<Touching>(*this, hand, model, keep(tool), stiffness);
}

const Tool& MutualTouch::keep(const Tool& tool) {
  const std::scoped_lock lock(mutex_);
  const auto at = std::find(kept_.begin(), kept_.end(), tool);
  return at != kept_.end() ? *at : kept_.emplace_back(tool);
}

void MutualTouch::enter(std::size_t hand, Place place) {
  if (is_there_[hand] == 0) ++presence_[hand];
  is_there_[hand] = 1;
  place.presence = presence_[hand];
  for (std::size_t other = 0; other < hands_; ++other) {
    if (other == hand) continue;
    Link& to = link(hand, other);
    to.place.back() = place;
    to.place.publish();
  }
}

void MutualTouch::leave(std::size_t hand) {
  if (is_there_[hand] == 0) return;
  is_there_[hand] = 0;
  for (std::size_t other = 0; other < hands_; ++other) {
    if (other == hand) continue;
    Link& to = link(hand, other);
    to.place.back() = {};
    to.place.publish();
    link(other, hand).were_apart = false;
  }
}

void MutualTouch::push(std::size_t hand, const Place& own, ForceOutput& felt) {
  for (std::size_t other = 0; other < hands_; ++other) {
    if (other == hand) continue;
    Link& from = link(other, hand);
    from.place.update();
    const Place& theirs = from.place.front();
    if (theirs.presence != from.presence) from.were_apart = false;
    from.presence = theirs.presence;
    if (theirs.presence == 0) continue;
    // In a fixed order, so that both hands find the same contact to the last bit.
    const bool is_low = hand < other;
    const bool meet = push_pair(is_low ? own : theirs, is_low ? theirs : own, is_low ? 1.0 : -1.0,
                                from.were_apart, own.pose, felt);
    from.were_apart = from.were_apart || !meet;
  }
}

/// Adds the wrench on the tool at `handle`. \param sign 1: that tool is `low`; -1: it is `high` \param pushes
/// false: only tests for overlap \returns true if the tools overlap, or if there are too many pairs to know.
bool MutualTouch::push_pair(const Place& low, const Place& high, double sign, bool pushes, const Pose& handle,
                            ForceOutput& felt) {
  if (!may_meet(low.pose.position, low.radius, high.pose.position, high.radius)) return false;
  NearPairs near;
  near.find(low.tool->parts(), low.pose, low.radius, high.tool->parts(), high.pose, high.radius);
  // Its own fraction is applied by each hand's governor.
  const double share = sign > 0.0 ? high.force_scale : low.force_scale;
  const double stiffness = share * in_series(low.stiffness, high.stiffness);
  const Place& own = sign > 0.0 ? low : high;
  bool meet = !near.are_all();
  std::optional<WhitenedTool> whitened;
  std::size_t whitened_part = 0;
  for (const NearPair& pair : near.pairs()) {
    if (!whitened || whitened_part != pair.low) whitened.emplace(low.tool->parts()[pair.low].at(low.pose));
    whitened_part = pair.low;
    const Ellipsoid two = high.tool->parts()[pair.high].at(high.pose);
    const KFunction k(*whitened, two);
    const KMinimum minimum = minimize(k);
    if (!(minimum.k_min > 0.0)) continue;
    meet = true;
    if (!pushes) return meet;
    const Contact contact = make_contact(*whitened, two, k, minimum);
    const Eigen::Vector3d force = sign * stiffness * contact.depth * contact.normal;
    felt.wrench.force += force;
    felt.wrench.torque += (contact.point - handle.position).cross(force);
    felt.stored_energy += 0.5 * stiffness * contact.depth * contact.depth;
    felt.stiffness += stiffness;
    felt.angular_stiffness += stiffness * own.radius * own.radius;
    felt.at_lever = true;
  }
  return meet;
}

}  // namespace palpate
