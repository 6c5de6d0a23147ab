#include <palpate/collision/index_builder.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <palpate/base/append.h>
#include <palpate/base/error.h>

namespace palpate {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// The ellipsoid of the lanes and that of the box are computed from the same numbers by a few different
/// operations each; the box is padded by more than their rounding, relative to its coordinates.
constexpr double kBoxPadding = 64.0 * std::numeric_limits<double>::epsilon();

constexpr std::uint32_t kWidth = kIndexWidth;
/// Gaussians are split by position, x, y and z, and by extent: one that is twenty times as large as its
/// neighbours, as found in captures, would make the box of their block as large.
constexpr int kKeys = 4;
constexpr int kExtent = 3;
constexpr std::uint32_t kParallelSize = 1U << 13;  ///< smaller ranges do not justify a task
constexpr int kBins = 16;                          ///< finer bins gain less than 1 % in Wald 2007
/// A range of at most this many Gaussians becomes one node with all its blocks, so that the many nodes at the
/// bottom are well filled.
constexpr std::uint32_t kBottomSize = kWidth * kWidth;

/// A box as two vectors of four with an unused fourth lane: bounds take one instruction per corner.
struct Box4 {
  Eigen::Array4f low = Eigen::Array4f::Constant(kInfinity);
  Eigen::Array4f high = Eigen::Array4f::Constant(-kInfinity);

  void extend(const Box4& other) {
    low = low.min(other.low);
    high = high.max(other.high);
  }
  /// Half the surface area; 0 for an empty box.
  float half_area() const {
    const Eigen::Array4f size = (high - low).max(0.0F);
    return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
  }
};

/// Box of a Gaussian. Items are sorted themselves, not by pointers, so that every pass over a range reads
/// memory in order. The number of the record is stored in the unused lane, as a float, since arithmetic on
/// its bits would be slow.
struct Item {
  Box4 box;

  Item() = default;
  Item(const Eigen::AlignedBox3f& b, std::uint32_t record) {
    box.low << b.min().array(), static_cast<float>(record);
    box.high << b.max().array(), 0.0F;
  }
  std::uint32_t record() const { return static_cast<std::uint32_t>(box.low[3]); }
  /// Coordinates that are split: twice the centre, and the extent.
  Eigen::Array4f key() const {
    Eigen::Array4f k = box.low + box.high;
    k[kExtent] = extent();
    return k;
  }
  float key(int axis) const { return axis == kExtent ? extent() : box.low[axis] + box.high[axis]; }
  float extent() const {
    const Eigen::Array4f size = box.high - box.low;
    return std::max(size[0], std::max(size[1], size[2]));
  }
};
static_assert(sizeof(Item) == 32, "two a cache line");
static_assert(kMaxTreeRecords <= 1U << 24, "a float counts no further");

/// Maps keys to bins.
struct Binning {
  Eigen::Array4f low, scale;

  /// \param keys from the least to the greatest of each
  explicit Binning(const Box4& keys) : low(keys.low) {
    scale = kBins / (keys.high - keys.low);
    scale = (scale < kInfinity).select(scale, 0.0F);  // all keys are equal: one bin
  }
  Eigen::Array4i operator()(const Eigen::Array4f& key) const {
    return ((key - low) * scale).cast<int>().min(kBins - 1).max(0);
  }
  int operator()(float key, int axis) const {
    return std::clamp(static_cast<int>((key - low[axis]) * scale[axis]), 0, kBins - 1);
  }
};

struct Bin {
  Box4 box;
  std::uint32_t count = 0;
};

struct Split {
  float cost = kInfinity;
  int axis = 0;
  int bin = 0;  ///< the first bin of the right side
};

/// The cheapest split between two bins of one axis.
Split best_split(const std::array<Bin, kBins>& bins, int axis) {
  std::array<float, kBins> right_cost{};
  Bin sweep;
  for (std::size_t b = kBins - 1; b > 0; --b) {
    sweep.box.extend(bins[b].box);
    sweep.count += bins[b].count;
    right_cost[b] = static_cast<float>(sweep.count) * sweep.box.half_area();
  }
  const std::uint32_t total = sweep.count + bins[0].count;
  Split best;
  sweep = {};
  for (std::size_t b = 1; b < kBins; ++b) {
    sweep.box.extend(bins[b - 1].box);
    sweep.count += bins[b - 1].count;
    if (sweep.count == 0 || sweep.count == total) continue;
    const float cost = static_cast<float>(sweep.count) * sweep.box.half_area() + right_cost[b];
    if (cost < best.cost) best = {cost, axis, static_cast<int>(b)};
  }
  return best;
}

/// Node of the binary tree that is built first: a range of items.
struct Range {
  Box4 box;
  std::uint32_t first, last;
  std::uint32_t left, right;  ///< nodes; both 0 if the range is one block

  std::uint32_t size() const { return last - first; }
};

/// Splits a range in two, down to blocks. Ranges begin at multiples of sixteen, and their number of blocks
/// determines the number of nodes below, so that branches write to separate places.
class BinaryBuilder {
 public:
  explicit BinaryBuilder(std::vector<Item> items) : items_(std::move(items)) {
    const auto n = static_cast<std::uint32_t>(items_.size());
    ranges_.resize(node_count(n));
    build(0, 0, n, 0);
  }

  const std::vector<Range>& ranges() const { return ranges_; }
  const std::vector<Item>& items() const { return items_; }

 private:
  static std::uint32_t node_count(std::uint32_t items) { return 2 * ((items + kWidth - 1) / kWidth) - 1; }

  void build(std::uint32_t self, std::uint32_t first, std::uint32_t last, std::uint32_t depth) {
    Range& range = ranges_[self];
    Box4 keys;
    range = {{}, first, last, 0, 0};
    for (std::uint32_t k = first; k < last; ++k) {
      range.box.extend(items_[k].box);
      const Eigen::Array4f key = items_[k].key();
      keys.low = keys.low.min(key);
      keys.high = keys.high.max(key);
    }
    if (last - first <= kWidth) return;
    const std::uint32_t middle = split(first, last, keys, depth);
    range.left = self + 1;
    range.right = range.left + node_count(middle - first);
    const auto left = [&, depth] { build(range.left, first, middle, depth + 1); };
    const auto right = [&, depth] { build(range.right, middle, last, depth + 1); };
    if (last - first < kParallelSize) {
      left();
      right();
    } else {
      tbb::parallel_invoke(left, right);
    }
  }

  Split best_split_of(std::uint32_t first, std::uint32_t last, const Binning& bin_of) const {
    std::array<std::array<Bin, kBins>, kKeys> bins;
    for (std::uint32_t k = first; k < last; ++k) {
      const Item& item = items_[k];
      const Eigen::Array4i b = bin_of(item.key());
      for (int axis = 0; axis < kKeys; ++axis) {
        Bin& bin = bins[static_cast<std::size_t>(axis)][static_cast<std::size_t>(b[axis])];
        bin.box.extend(item.box);
        ++bin.count;
      }
    }
    Split best;
    for (int axis = 0; axis < kKeys; ++axis) {
      const Split split = best_split(bins[static_cast<std::size_t>(axis)], axis);
      if (split.cost < best.cost) best = split;
    }
    return best;
  }

  /// Orders [first, last) so that the two sides of a split are separate, with full blocks on the left.
  /// \returns the end of the left side.
  std::uint32_t split(std::uint32_t first, std::uint32_t last, const Box4& keys, std::uint32_t depth) {
    const std::uint32_t blocks = (last - first + kWidth - 1) / kWidth;
    const std::uint32_t half = first + blocks / 2 * kWidth;
    const Binning bin_of(keys);
    const Split split = best_split_of(first, last, bin_of);
    if (!std::isfinite(split.cost)) return half;  // all keys are equal
    const int axis = split.axis;
    if (depth >= kMaxIndexDepth / 2) {
      order_around(first, half, last, axis);
      return half;
    }
    const auto is_left = [&](const Item& item) { return bin_of(item.key(axis), axis) < split.bin; };
    const auto items = items_.begin();
    const auto meet =
        static_cast<std::uint32_t>(std::partition(items + first, items + last, is_left) - items);
    const std::uint32_t middle =
        first + std::clamp((meet - first + kWidth / 2) / kWidth, 1U, blocks - 1) * kWidth;
    if (middle < meet) order_around(first, middle, meet, axis);
    if (middle > meet) order_around(meet, middle, last, axis);
    return middle;
  }

  /// Orders [first, last) along `axis` so that no item before `middle` is beyond one after it.
  void order_around(std::uint32_t first, std::uint32_t middle, std::uint32_t last, int axis) {
    const auto items = items_.begin();
    std::nth_element(items + first, items + middle, items + last,
                     [axis](const Item& a, const Item& b) { return a.key(axis) < b.key(axis); });
  }

  std::vector<Item> items_;
  std::vector<Range> ranges_;
};

IndexNode empty_node() {
  IndexNode node;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    node.low[axis].fill(kInfinity);
    node.high[axis].fill(-kInfinity);
  }
  node.child.fill(0);
  return node;
}

void set_slot(IndexNode& node, std::size_t slot, const Box4& box, std::uint32_t child) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    node.low[axis][slot] = box.low[static_cast<int>(axis)];
    node.high[axis][slot] = box.high[static_cast<int>(axis)];
  }
  node.child[slot] = child;
}

/// Gathers the binary tree into nodes of up to sixteen children.
class WideBuilder {
 public:
  explicit WideBuilder(const std::vector<Range>& ranges) : ranges_(ranges) { add(0); }

  std::vector<IndexNode> take() { return std::move(nodes_); }

 private:
  std::uint32_t add(std::uint32_t root) {
    std::array<std::uint32_t, kWidth> open{root};
    std::uint32_t count = 1;
    const bool bottom = ranges_[root].size() <= kBottomSize;
    while (count < kWidth) {
      const std::uint32_t widest = largest_to_open(open, count, bottom ? kWidth : kBottomSize);
      if (widest == count) break;
      const Range& range = ranges_[open[widest]];
      open[widest] = range.left;
      open[count++] = range.right;
    }
    const auto self = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back(empty_node());
    for (std::uint32_t k = 0; k < count; ++k) {
      const Range& range = ranges_[open[k]];
      const std::uint32_t child =
          range.size() <= kWidth ? range.first / kWidth | IndexNode::kLeaf : add(open[k]);
      set_slot(nodes_[self], k, range.box, child);
    }
    return self;
  }

  /// The open range to be replaced by its halves: the one with the largest surface of those with more than
  /// `least` items; `count` if there is none.
  std::uint32_t largest_to_open(const std::array<std::uint32_t, kWidth>& open, std::uint32_t count,
                                std::uint32_t least) const {
    std::uint32_t best = count;
    float best_area = -1.0F;
    for (std::uint32_t k = 0; k < count; ++k) {
      const Range& range = ranges_[open[k]];
      if (range.size() <= least) continue;
      const float area = range.box.half_area();
      if (area > best_area) {
        best_area = area;
        best = k;
      }
    }
    return best;
  }

  const std::vector<Range>& ranges_;
  std::vector<IndexNode> nodes_;
};

/// Fills a block with `items`, at most sixteen, in increasing order of id.
void fill_block(std::span<const Item> items, std::span<const GaussianRecord> records, GaussianBlock& block) {
  std::array<const GaussianRecord*, kIndexWidth> lane{};
  for (std::size_t k = 0; k < items.size(); ++k) lane[k] = &records[items[k].record()];
  std::sort(lane.begin(), lane.begin() + items.size(),
            [](const GaussianRecord* a, const GaussianRecord* b) { return a->id < b->id; });
  constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
  const GaussianRecord none{{kNowhere, kNowhere, kNowhere}, {}, {}, {1, 0, 0, 0}, 0, 0, 0xffffffffU};
  for (std::size_t k = 0; k < kIndexWidth; ++k) {
    const GaussianRecord& r = k < items.size() ? *lane[k] : none;
    for (std::size_t i = 0; i < 3; ++i) block.position[i][k] = r.position[i];
    for (std::size_t i = 0; i < 3; ++i) block.length_high[i][k] = r.length_high[i];
    for (std::size_t i = 0; i < 3; ++i) block.length_low[i][k] = r.length_low[i];
    for (std::size_t i = 0; i < 4; ++i) block.rotation[i][k] = r.rotation[i];
    block.opacity_high[k] = r.opacity_high;
    block.opacity_low[k] = r.opacity_low;
    block.id[k] = r.id;
  }
}

}  // namespace

Eigen::AlignedBox3f outer_box(const Eigen::Vector3f& position, const Eigen::Vector3d& half) {
  const auto down = [](double v) { return std::nextafter(static_cast<float>(v), -kInfinity); };
  const auto up = [](double v) { return std::nextafter(static_cast<float>(v), kInfinity); };
  const Eigen::Vector3d center = position.cast<double>();
  const Eigen::Vector3d reach = half + kBoxPadding * (center.cwiseAbs() + half);
  return {(center - reach).unaryExpr(down), (center + reach).unaryExpr(up)};
}

IndexTree build_tree(std::span<const GaussianRecord> records, std::span<const Eigen::AlignedBox3f> boxes) {
  std::vector<Item> items(records.size());
  tbb::parallel_for(std::size_t{0}, items.size(),
                    [&](std::size_t i) { items[i] = Item(boxes[i], static_cast<std::uint32_t>(i)); });
  const BinaryBuilder binary(std::move(items));

  IndexTree tree;
  tree.nodes = WideBuilder(binary.ranges()).take();
  const Box4& all = binary.ranges().front().box;
  tree.box = {all.low.head<3>().matrix(), all.high.head<3>().matrix()};

  const std::size_t n = records.size();
  const std::size_t block_count = (n + kIndexWidth - 1) / kIndexWidth;
  tree.blocks.resize(block_count);
  tbb::parallel_for(std::size_t{0}, block_count, [&](std::size_t b) {
    const std::size_t first = b * kIndexWidth;
    const std::span<const Item> of_block(&binary.items()[first], std::min(kIndexWidth, n - first));
    fill_block(of_block, records, tree.blocks[b]);
  });
  return tree;
}

namespace {

/// Shifts the children of `nodes`.
void move_children(std::vector<IndexNode>& nodes, std::uint32_t by_nodes, std::uint32_t by_blocks) {
  for (IndexNode& node : nodes) {
    for (std::size_t slot = 0; slot < kIndexWidth; ++slot) {
      if (node.low[0][slot] > node.high[0][slot]) continue;
      node.child[slot] += (node.child[slot] & IndexNode::kLeaf) != 0 ? by_blocks : by_nodes;
    }
  }
}

}  // namespace

std::vector<GaussianBlock> IndexForest::plant(IndexTree tree) {
  if (blocks_ + tree.blocks.size() > kMaxIndexBlocks) {
    throw Error("more than {} Gaussians do not fit into one index; crop the scene",
                kMaxIndexBlocks * kIndexWidth);
  }
  move_children(tree.nodes, static_cast<std::uint32_t>(nodes_.size()), static_cast<std::uint32_t>(blocks_));
  roots_.push_back({tree.box, static_cast<std::uint32_t>(nodes_.size())});
  append(nodes_, tree.nodes);
  blocks_ += tree.blocks.size();
  return std::move(tree.blocks);
}

std::vector<IndexNode> IndexForest::join() {
  if (roots_.size() <= 1) return std::move(nodes_);
  // Consecutive trees are neighbours in space. The levels above are counted first, since they are stored in
  // front and shift those below.
  std::vector<IndexNode> top;
  std::vector<Root> level = std::move(roots_);
  std::vector<std::vector<IndexNode>> levels;
  while (level.size() > 1) {
    std::vector<IndexNode> nodes((level.size() + kIndexWidth - 1) / kIndexWidth, empty_node());
    std::vector<Root> next(nodes.size());
    for (std::size_t k = 0; k < level.size(); ++k) {
      const Item item(level[k].box, 0);
      set_slot(nodes[k / kIndexWidth], k % kIndexWidth, item.box, level[k].node);
      next[k / kIndexWidth].box.extend(level[k].box);
      next[k / kIndexWidth].node = static_cast<std::uint32_t>(k / kIndexWidth);
    }
    levels.push_back(std::move(nodes));
    level = std::move(next);
  }
  std::reverse(levels.begin(), levels.end());
  std::uint32_t end = 0;
  for (std::vector<IndexNode>& nodes : levels) {
    end += static_cast<std::uint32_t>(nodes.size());
    move_children(nodes, end, 0);  // the level below begins where this one ends
    append(top, nodes);
  }
  move_children(nodes_, end, 0);
  append(top, nodes_);
  nodes_.clear();
  return top;
}

}  // namespace palpate
