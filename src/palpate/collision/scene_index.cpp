#include <palpate/collision/scene_index.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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

using Box3f = Eigen::AlignedBox3f;

/// Surface area, up to a factor; 0 for an empty box.
float half_area(const Box3f& box) {
  if (box.isEmpty()) return 0.0F;
  const Eigen::Vector3f size = box.sizes();
  return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
}

}  // namespace

/// Builds the tree top down by the surface area heuristic over binned box centres (Wald 2007).
class SceneIndex::Builder {
 public:
  explicit Builder(const EllipsoidScene& scene) : items_(scene.size()) {
    tbb::parallel_for(std::size_t{0}, scene.size(), [&](std::size_t i) {
      const Box box = padded_box(scene.ellipsoids[i]);
      items_[i] = {Box3f(box.min().unaryExpr(&round_down), box.max().unaryExpr(&round_up)),
                   static_cast<std::uint32_t>(i)};
    });
  }

  std::vector<Node> build() {
    std::vector<Node> nodes;
    if (!items_.empty()) build(0, static_cast<std::uint32_t>(items_.size()), nodes);
    return nodes;
  }

  /// Gaussians in the order of the leaves.
  std::vector<std::uint32_t> order() const {
    std::vector<std::uint32_t> order;
    order.reserve(items_.size());
    for (const Item& item : items_) order.push_back(item.gaussian);
    return order;
  }

 private:
  static constexpr std::uint32_t kLeafSize = 4;             // 416 bytes of ellipsoids: a few cache lines
  static constexpr std::uint32_t kParallelSize = 1U << 14;  // smaller ranges are not worth a task
  static constexpr int kBins = 16;                          // finer bins gain less than 1 % in Wald 2007

  /// A Gaussian's box, rounded outwards. The items themselves are sorted, not pointers to them, so
  /// that every pass over a range reads memory in order.
  struct Item {
    Box3f box;
    std::uint32_t gaussian;

    float center(int axis) const { return 0.5F * box.min()[axis] + 0.5F * box.max()[axis]; }
  };
  struct Bin {
    Box3f box;
    std::uint32_t count = 0;
  };
  struct Split {
    float cost = std::numeric_limits<float>::infinity();
    int axis = 0;
    int bin = 0;  ///< the first bin of the right side
  };
  /// Maps a box centre to its bin along one axis.
  struct Binning {
    float low, scale;
    int operator()(float center) const {
      return std::clamp(static_cast<int>((center - low) * scale), 0, kBins - 1);
    }
  };
  struct Bounds {
    Box3f boxes;
    Box3f centers;
  };

  Bounds bounds(std::uint32_t first, std::uint32_t last) const {
    Bounds result;
    for (std::uint32_t k = first; k < last; ++k) {
      const Item& item = items_[k];
      result.boxes.extend(item.box);
      result.centers.extend(Eigen::Vector3f(item.center(0), item.center(1), item.center(2)));
    }
    return result;
  }

  static Binning binning(const Box3f& centers, int axis) {
    return {centers.min()[axis], kBins / (centers.max()[axis] - centers.min()[axis])};
  }

  /// The cheapest of the splits between two bins of one axis.
  static Split best_split(const std::array<Bin, kBins>& bins, int axis) {
    std::array<float, kBins> right_cost{};
    Bin sweep;
    for (std::size_t b = kBins - 1; b > 0; --b) {
      sweep.box.extend(bins[b].box);
      sweep.count += bins[b].count;
      right_cost[b] = static_cast<float>(sweep.count) * half_area(sweep.box);
    }
    const std::uint32_t total = sweep.count + bins[0].count;
    Split best;
    sweep = {};
    for (std::size_t b = 1; b < kBins; ++b) {
      sweep.box.extend(bins[b - 1].box);
      sweep.count += bins[b - 1].count;
      if (sweep.count == 0 || sweep.count == total) continue;
      const float cost = static_cast<float>(sweep.count) * half_area(sweep.box) + right_cost[b];
      if (cost < best.cost) best = {cost, axis, static_cast<int>(b)};
    }
    return best;
  }

  Split best_split(std::uint32_t first, std::uint32_t last, const Box3f& centers) const {
    std::array<Binning, 3> bin_of;
    for (int axis = 0; axis < 3; ++axis) bin_of[static_cast<std::size_t>(axis)] = binning(centers, axis);
    std::array<std::array<Bin, kBins>, 3> bins;
    for (std::uint32_t k = first; k < last; ++k) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!std::isfinite(bin_of[axis].scale)) continue;  // all centres share this coordinate
        const int b = bin_of[axis](items_[k].center(static_cast<int>(axis)));
        Bin& bin = bins[axis][static_cast<std::size_t>(b)];
        bin.box.extend(items_[k].box);
        ++bin.count;
      }
    }
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
      const Split split = best_split(bins[static_cast<std::size_t>(axis)], axis);
      if (split.cost < best.cost) best = split;
    }
    return best;
  }

  /// Orders [first, last) so that the two sides of the split are apart; returns where they meet.
  std::uint32_t partition(std::uint32_t first, std::uint32_t last, const Box3f& centers) {
    const Split split = best_split(first, last, centers);
    if (!std::isfinite(split.cost)) return first + (last - first) / 2;  // nothing tells them apart
    const Binning bin_of = binning(centers, split.axis);
    const auto middle = std::partition(items_.begin() + first, items_.begin() + last, [&](const Item& item) {
      return bin_of(item.center(split.axis)) < split.bin;
    });
    return static_cast<std::uint32_t>(middle - items_.begin());
  }

  void build(std::uint32_t first, std::uint32_t last, std::vector<Node>& nodes) {
    const Bounds around = bounds(first, last);
    const std::size_t self = nodes.size();
    Node node{};
    for (int axis = 0; axis < 3; ++axis) {
      node.low[axis] = around.boxes.min()[axis];
      node.high[axis] = around.boxes.max()[axis];
    }
    node.right = first;
    node.count = last - first;
    nodes.push_back(node);
    if (last - first <= kLeafSize) return;

    const std::uint32_t middle = partition(first, last, around.centers);
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

  std::vector<Item> items_;
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
    const std::vector<std::uint32_t> order = builder.order();
    reorder(scene_.ellipsoids, order);
    reorder(scene_.opacity, order);
    reorder(scene_.id, order);
    reorder(scene_.color, order);
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
