#include <palpate/collision/scene_index.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <Eigen/Geometry>

namespace palpate {
namespace {

using Box = Eigen::AlignedBox3d;

/// Rounding of centre and half extents, each a handful of operations, can make a tight box smaller
/// than its ellipsoid by a few units in the last place; the box is padded by more than that.
constexpr double kBoxPadding = 8.0 * std::numeric_limits<double>::epsilon();

Box padded_box(const Ellipsoid& e) {
  const Eigen::Vector3d half = e.half_extents();
  const Eigen::Vector3d pad = kBoxPadding * (e.center.cwiseAbs() + half);
  return {e.center - half - pad, e.center + half + pad};
}

float round_down(double v) {
  return std::nextafter(static_cast<float>(v), -std::numeric_limits<float>::infinity());
}
float round_up(double v) {
  return std::nextafter(static_cast<float>(v), std::numeric_limits<float>::infinity());
}

/// Surface area, up to a factor; 0 for an empty box.
double half_area(const Box& box) {
  if (box.isEmpty()) return 0.0;
  const Eigen::Vector3d size = box.sizes();
  return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
}

}  // namespace

/// Builds the tree top down by the surface area heuristic over binned box centres (Wald 2007).
class SceneIndex::Builder {
 public:
  explicit Builder(const EllipsoidScene& scene) : boxes_(scene.size()), order_(scene.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    tbb::parallel_for(std::size_t{0}, scene.size(),
                      [&](std::size_t i) { boxes_[i] = padded_box(scene.ellipsoids[i]); });
  }

  std::vector<Node> build() {
    std::vector<Node> nodes;
    if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()), nodes);
    return nodes;
  }

  /// Gaussians in the order of the leaves.
  const std::vector<std::uint32_t>& order() const { return order_; }

 private:
  static constexpr std::uint32_t kLeafSize = 4;             // 416 bytes of ellipsoids: a few cache lines
  static constexpr std::uint32_t kParallelSize = 1U << 14;  // smaller ranges are not worth a task
  static constexpr int kBins = 16;                          // finer bins gain less than 1 % in Wald 2007

  struct Bin {
    Box box;
    std::uint32_t count = 0;
  };
  struct Split {
    double cost = std::numeric_limits<double>::infinity();
    int axis = 0;
    int bin = 0;  ///< the first bin of the right side
  };
  /// Maps a box centre to its bin along one axis.
  struct Binning {
    double low, scale;
    int operator()(double center) const {
      return std::clamp(static_cast<int>((center - low) * scale), 0, kBins - 1);
    }
  };

  Box bounds(std::uint32_t first, std::uint32_t last, Box& centers) const {
    Box box;
    for (std::uint32_t k = first; k < last; ++k) {
      box.extend(boxes_[order_[k]]);
      centers.extend(boxes_[order_[k]].center());
    }
    return box;
  }

  static Binning binning(const Box& centers, int axis) {
    return {centers.min()[axis], kBins / (centers.max()[axis] - centers.min()[axis])};
  }

  Split best_split(std::uint32_t first, std::uint32_t last, const Box& centers) const {
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
      const Binning bin_of = binning(centers, axis);
      if (!std::isfinite(bin_of.scale)) continue;  // all centres share this coordinate
      std::array<Bin, kBins> bins;
      for (std::uint32_t k = first; k < last; ++k) {
        const Box& box = boxes_[order_[k]];
        Bin& bin = bins[static_cast<std::size_t>(bin_of(box.center()[axis]))];
        bin.box.extend(box);
        ++bin.count;
      }
      std::array<double, kBins> right_cost{};
      Bin sweep;
      for (int b = kBins - 1; b > 0; --b) {
        sweep.box.extend(bins[static_cast<std::size_t>(b)].box);
        sweep.count += bins[static_cast<std::size_t>(b)].count;
        right_cost[static_cast<std::size_t>(b)] = sweep.count * half_area(sweep.box);
      }
      sweep = {};
      for (int b = 1; b < kBins; ++b) {
        sweep.box.extend(bins[static_cast<std::size_t>(b) - 1].box);
        sweep.count += bins[static_cast<std::size_t>(b) - 1].count;
        if (sweep.count == 0 || sweep.count == last - first) continue;
        const double cost = sweep.count * half_area(sweep.box) + right_cost[static_cast<std::size_t>(b)];
        if (cost < best.cost) best = {cost, axis, b};
      }
    }
    return best;
  }

  /// Orders [first, last) so that the two sides of the split are apart; returns where they meet.
  std::uint32_t partition(std::uint32_t first, std::uint32_t last, const Box& centers) {
    const Split split = best_split(first, last, centers);
    if (!std::isfinite(split.cost)) return first + (last - first) / 2;  // nothing tells them apart
    const Binning bin_of = binning(centers, split.axis);
    const auto middle = std::partition(order_.begin() + first, order_.begin() + last, [&](std::uint32_t i) {
      return bin_of(boxes_[i].center()[split.axis]) < split.bin;
    });
    return static_cast<std::uint32_t>(middle - order_.begin());
  }

  void build(std::uint32_t first, std::uint32_t last, std::vector<Node>& nodes) {
    Box centers;
    const Box box = bounds(first, last, centers);
    const std::size_t self = nodes.size();
    Node node{};
    for (int axis = 0; axis < 3; ++axis) {
      node.low[axis] = round_down(box.min()[axis]);
      node.high[axis] = round_up(box.max()[axis]);
    }
    node.right = first;
    node.count = last - first;
    nodes.push_back(node);
    if (last - first <= kLeafSize) return;

    const std::uint32_t middle = partition(first, last, centers);
    nodes[self].count = 0;
    if (last - first < kParallelSize) {
      build(first, middle, nodes);
      nodes[self].right = static_cast<std::uint32_t>(nodes.size() - self);
      build(middle, last, nodes);
      return;
    }
    // Offsets are relative, so two trees join by putting one behind the other.
    std::vector<Node> left, right;
    tbb::parallel_invoke([&] { build(first, middle, left); }, [&] { build(middle, last, right); });
    nodes[self].right = static_cast<std::uint32_t>(1 + left.size());
    nodes.insert(nodes.end(), left.begin(), left.end());
    nodes.insert(nodes.end(), right.begin(), right.end());
  }

  std::vector<Box> boxes_;
  std::vector<std::uint32_t> order_;
};

namespace {

template <typename T>
void reorder(std::vector<T>& values, const std::vector<std::uint32_t>& order) {
  if (values.empty()) return;
  std::vector<T> sorted;
  sorted.reserve(values.size());
  for (const std::uint32_t i : order) sorted.push_back(values[i]);
  values = std::move(sorted);
}

}  // namespace

SceneIndex::SceneIndex(EllipsoidScene scene, const Progress& progress) : scene_(std::move(scene)) {
  report(progress, "indexing", 0.0);
  {
    Builder builder(scene_);
    nodes_ = builder.build();
    report(progress, "indexing", 0.8);
    reorder(scene_.ellipsoids, builder.order());
    reorder(scene_.opacity, builder.order());
    reorder(scene_.id, builder.order());
    reorder(scene_.color, builder.order());
  }
  report(progress, "indexing", 1.0);
}

void SceneIndex::query(const Ellipsoid& tool, ContactSet& result) const {
  result.clear();
  if (nodes_.empty()) return;
  const WhitenedTool whitened(tool);
  const Box tool_box = padded_box(tool);
  const double tool_radius = tool.radius();

  const auto misses = [&](const Node& node) {
    for (int axis = 0; axis < 3; ++axis) {
      if (tool_box.max()[axis] < node.low[axis] || tool_box.min()[axis] > node.high[axis]) return true;
    }
    return false;
  };
  const auto test = [&](std::uint32_t i) {
    const Ellipsoid& gaussian = scene_.ellipsoids[i];
    if (!padded_box(gaussian).intersects(tool_box)) return;
    ++result.candidates;
    if (!spheres_overlap(gaussian, gaussian.radius(), tool, tool_radius)) return;
    ++result.filtered;
    const KFunction k(whitened, gaussian);
    const KMinimum minimum = minimize(k);
    if (!(minimum.k_min > 0.0)) return;
    Contact& contact = result.contacts.emplace_back(make_contact(whitened, gaussian, k, minimum));
    contact.id = scene_.id[i];
    contact.opacity = scene_.opacity[i];
  };

  // Depth first. The stack holds the right children still to be seen; a vector, because nothing
  // bounds the depth of a tree over adversarial sizes.
  std::vector<const Node*> pending{nodes_.data()};
  while (!pending.empty()) {
    const Node* node = pending.back();
    pending.pop_back();
    while (!misses(*node)) {
      if (node->count != 0) {
        for (std::uint32_t k = 0; k < node->count; ++k) test(node->right + k);
        break;
      }
      pending.push_back(node + node->right);
      ++node;
    }
  }
  std::sort(result.contacts.begin(), result.contacts.end(),
            [](const Contact& a, const Contact& b) { return a.id < b.id; });
}

std::size_t SceneIndex::bytes() const {
  const auto held = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
  return held(nodes_) + held(scene_.ellipsoids) + held(scene_.opacity) + held(scene_.id) + held(scene_.color);
}

}  // namespace palpate
