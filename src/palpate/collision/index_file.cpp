#include <palpate/collision/index_file.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

#include <tbb/parallel_for.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <palpate/base/error.h>

namespace palpate {
namespace {

constexpr std::array<char, 8> kMagic{'P', 'A', 'L', 'P', 'A', 'T', 'E', '\n'};
constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kByteOrder = 0x01020304;
constexpr std::size_t kPage = 4096;
constexpr std::size_t kChunk = std::size_t{1} << 20;  ///< per hash: one core reads it in 0.1 ms

/// First page of the file.
struct IndexFront {
  std::array<char, 8> magic;
  std::uint32_t byte_order;
  std::uint32_t version;
  std::array<char, kPage - 16> unused;
};
static_assert(sizeof(IndexFront) == kPage);

/// Last page: everything but the arrays. Plain numbers and characters, so that any bytes are a valid object.
struct IndexTrailer {
  std::uint64_t own_hash;  ///< XXH3 of all that follows
  std::array<char, 8> magic;
  std::uint64_t file_size;
  std::uint64_t blocks, nodes, gaussians;
  double origin[3];
  std::uint64_t table_hash;  ///< XXH3 of the table of hashes
  std::uint64_t source_size, source_content;
  std::int64_t source_modified_ns, source_changed_ns;
  std::uint64_t report[6 + kDefectCount];  ///< FilterReport, member by member
  std::array<char, 2048> options;          ///< ended by a zero
  std::array<char, 1848> unused;
};
static_assert(sizeof(IndexTrailer) == kPage);

std::uint64_t hash(const void* data, std::size_t size) { return XXH3_64bits(data, size); }

std::uint64_t own_hash(const IndexTrailer& t) {
  const auto* bytes = reinterpret_cast<const char*>(&t);
  return hash(bytes + sizeof t.own_hash, sizeof t - sizeof t.own_hash);
}

template <typename T>
std::string_view bytes_of(std::span<const T> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

void pack(const FilterReport& r, IndexTrailer& t) {
  std::uint64_t* to = t.report;
  for (const std::size_t value :
       {r.total, r.low_opacity, r.below_iso, r.over_max_scale, r.outside_crop, r.kept})
    *to++ = value;
  std::copy(r.defects.begin(), r.defects.end(), to);
}

FilterReport unpack_report(const IndexTrailer& t) {
  FilterReport r;
  const std::uint64_t* from = t.report;
  for (std::size_t* value :
       {&r.total, &r.low_opacity, &r.below_iso, &r.over_max_scale, &r.outside_crop, &r.kept})
    *value = *from++;
  std::copy(from, from + kDefectCount, r.defects.begin());
  return r;
}

IndexTrailer pack(const IndexDescription& d) {
  IndexTrailer t{};
  t.magic = kMagic;
  t.gaussians = d.gaussians;
  std::copy_n(d.origin.data(), 3, t.origin);
  t.source_size = d.source.stamp.size;
  t.source_content = d.source.content;
  t.source_modified_ns = d.source.stamp.modified_ns;
  t.source_changed_ns = d.source.stamp.changed_ns;
  pack(d.report, t);
  std::copy_n(d.options.begin(), std::min(d.options.size(), t.options.size() - 1), t.options.begin());
  return t;
}

IndexDescription unpack(const IndexTrailer& t) {
  IndexDescription d;
  d.gaussians = t.gaussians;
  d.origin = {t.origin[0], t.origin[1], t.origin[2]};
  d.source = {{t.source_size, t.source_modified_ns, t.source_changed_ns}, t.source_content};
  d.report = unpack_report(t);
  d.options.assign(t.options.data(), ::strnlen(t.options.data(), t.options.size()));
  return d;
}

/// Cuts arrays off the front of a file, each of which must fit into the rest.
class Cutter {
 public:
  explicit Cutter(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <typename T>
  std::span<const T> take(std::uint64_t count) {
    if (count > rest_.size() / sizeof(T)) {
      fits_ = false;
      return {};
    }
    const std::span<const T> result(reinterpret_cast<const T*>(rest_.data()), count);
    rest_ = rest_.subspan(count * sizeof(T));
    return result;
  }
  bool fits_exactly() const { return fits_ && rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
  bool fits_ = true;
};

/// Index of the first chunk of `bytes` whose hash differs from the table; the number of chunks if there is
/// none.
std::size_t first_changed_chunk(std::span<const std::byte> bytes, std::span<const std::uint64_t> table) {
  std::atomic<std::size_t> first = table.size();
  tbb::parallel_for(std::size_t{0}, table.size(), [&](std::size_t i) {
    const std::span<const std::byte> chunk =
        bytes.subspan(i * kChunk, std::min(kChunk, bytes.size() - i * kChunk));
    if (hash(chunk.data(), chunk.size()) == table[i]) return;
    std::size_t seen = first;
    while (i < seen && !first.compare_exchange_weak(seen, i)) {
    }
  });
  return first;
}

/// Returns true if `index` is a tree over all of its nodes and blocks: every node but the root, which is the
/// first, and every block is the child of exactly one slot. Hence, whoever wrote the file, a traversal never
/// leaves the arrays, visits nothing twice, ends, and reaches everything in the file.
///
/// Children come after their parents in the builder's order, as in any valid file, so that one pass in memory
/// order sees the parent of a node first: a node without a depth by then has no parent. With one parent each,
/// stored in front, all nodes descend from the root.
bool is_tree(const IndexView& index) {
  if (index.blocks.size() > kMaxIndexBlocks) return false;
  std::vector<std::uint8_t> depth(index.nodes.size(), 0);  // 0 where no parent has been seen
  std::vector<bool> is_child(index.blocks.size(), false);
  std::size_t blocks_seen = 0;
  for (std::size_t n = 0; n < index.nodes.size(); ++n) {
    const IndexNode& node = index.nodes[n];
    if (n > 0 && depth[n] == 0) return false;
    for (std::size_t slot = 0; slot < kIndexWidth; ++slot) {
      const std::uint32_t child = node.child[slot];
      if (child == 0) {  // no child: its box must be empty
        if (node.low[0][slot] <= std::numeric_limits<float>::max()) return false;
        continue;
      }
      for (std::size_t axis = 0; axis < 3; ++axis) {  // an empty box or NaN would hide the child
        if (!(node.low[axis][slot] <= node.high[axis][slot])) return false;
      }
      if ((child & IndexNode::kLeaf) != 0) {
        const std::uint32_t block = child & ~IndexNode::kLeaf;
        if (block >= index.blocks.size() || is_child[block]) return false;
        is_child[block] = true;
        ++blocks_seen;
      } else {
        const bool sound = child > n && child < index.nodes.size() && depth[child] == 0;
        if (!sound || depth[n] + 1U >= kMaxIndexDepth) return false;
        depth[child] = static_cast<std::uint8_t>(depth[n] + 1);
      }
    }
  }
  return blocks_seen == index.blocks.size();
}

}  // namespace

std::uint64_t content_hash(const std::string& path) {
  constexpr std::size_t kPart = std::size_t{16} << 20;
  constexpr std::size_t kRead = std::size_t{1} << 18;  // fits the second-level cache
  const InputFile file(path);
  std::vector<std::uint64_t> hashes((file.size() + kPart - 1) / kPart);
  tbb::parallel_for(std::size_t{0}, hashes.size(), [&](std::size_t i) {
    const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
    XXH3_64bits_reset(state.get());
    std::vector<char> buffer(kRead);
    const std::uint64_t end = std::min<std::uint64_t>(file.size(), (i + 1) * kPart);
    for (std::uint64_t at = i * kPart; at < end; at += kRead) {
      const std::size_t n = std::min<std::uint64_t>(kRead, end - at);
      file.read(at, {buffer.data(), n});
      XXH3_64bits_update(state.get(), buffer.data(), n);
    }
    hashes[i] = XXH3_64bits_digest(state.get());
  });
  return hash(hashes.data(), hashes.size() * sizeof(hashes[0]));
}

std::string index_options(const SceneFilter& filter, const Similarity& world) {
  std::string text = fmt::format("--opacity-min {}", filter.opacity_min);
  text += filter.iso ? fmt::format(" --iso {}", *filter.iso) : fmt::format(" --sigma {}", filter.sigma);
  if (filter.max_scale) text += fmt::format(" --max-scale {}", *filter.max_scale);
  if (filter.crop_box) {
    const Eigen::Vector3d &a = filter.crop_box->min(), &b = filter.crop_box->max();
    text += fmt::format(" --crop-box {},{},{},{},{},{}", a[0], a[1], a[2], b[0], b[1], b[2]);
  }
  if (filter.crop_sphere) {
    const Eigen::Vector3d& c = filter.crop_sphere->center;
    text += fmt::format(" --crop-sphere {},{},{},{}", c[0], c[1], c[2], filter.crop_sphere->radius);
  }
  // Gaussians beyond kMaxExtent in the world are removed. Only registrations beyond these limits take real
  // ones there.
  constexpr double kLargestScale = 1e3, kFarthest = 1e9;
  const bool far = world.scale > kLargestScale || world.translation.norm() > kFarthest;
  if (filter.max_scale || filter.crop_box || filter.crop_sphere || far) {
    const Eigen::Quaterniond& q = world.rotation;
    const Eigen::Vector3d& t = world.translation;
    text += fmt::format(" --scale {} --rotate {},{},{},{} --translate {},{},{}", world.scale, q.w(), q.x(),
                        q.y(), q.z(), t[0], t[1], t[2]);
    if (world.mirrored) text += " --mirror";
  }
  return text;
}

std::optional<IndexSource> index_source(const std::string& path) {
  try {
    const InputFile file(path);
    IndexFront front{};
    IndexTrailer t{};
    if (file.size() < 2 * kPage) return std::nullopt;
    file.read(0, {reinterpret_cast<char*>(&front), sizeof front});
    file.read(file.size() - sizeof t, {reinterpret_cast<char*>(&t), sizeof t});
    const bool known = front.magic == kMagic && front.byte_order == kByteOrder && front.version == kVersion;
    if (!known || t.magic != kMagic || t.file_size != file.size() || t.own_hash != own_hash(t))
      return std::nullopt;
    return unpack(t).source;
  } catch (const Error&) {
    return std::nullopt;  // there is no index
  }
}

IndexWriter::IndexWriter(const std::string& path) : file_(path) {
  const IndexFront front{kMagic, kByteOrder, kVersion, {}};
  write({reinterpret_cast<const char*>(&front), sizeof front});
}

void IndexWriter::write(std::string_view bytes) {
  size_ += bytes.size();
  file_.write(bytes);
  while (!bytes.empty()) {
    if (chunk_.empty() && bytes.size() >= kChunk) {  // whole chunks need no copy
      hashes_.push_back(hash(bytes.data(), kChunk));
      bytes.remove_prefix(kChunk);
      continue;
    }
    const std::size_t n = std::min(bytes.size(), kChunk - chunk_.size());
    chunk_ += bytes.substr(0, n);
    bytes.remove_prefix(n);
    if (chunk_.size() < kChunk) continue;
    hashes_.push_back(hash(chunk_.data(), kChunk));
    chunk_.clear();
  }
}

void IndexWriter::add(std::span<const GaussianBlock> blocks) {
  write(bytes_of(blocks));
  blocks_ += blocks.size();
}

void IndexWriter::finish(std::span<const IndexNode> nodes, const IndexDescription& description) {
  write(bytes_of(nodes));
  if (!chunk_.empty()) hashes_.push_back(hash(chunk_.data(), chunk_.size()));
  const std::string_view table = bytes_of(std::span<const std::uint64_t>(hashes_));

  IndexTrailer t = pack(description);
  t.blocks = blocks_;
  t.nodes = nodes.size();
  t.table_hash = hash(table.data(), table.size());
  t.file_size = size_ + table.size() + sizeof t;
  t.own_hash = own_hash(t);
  file_.write(table);
  file_.write({reinterpret_cast<const char*>(&t), sizeof t});
  file_.commit(OutputFile::Sync::kNo);  // can be rebuilt, and is verified on opening
}

IndexFile::IndexFile(const std::string& path, const std::string& scene, const std::string& options,
                     FileMemory memory)
    : file_(path, memory) {
  const std::span<const std::byte> bytes = file_.bytes();
  IndexFront front{};
  std::memcpy(&front, bytes.data(), std::min(bytes.size(), sizeof front));
  if (front.magic != kMagic) throw Error("{}: is not a palpate index", path);
  if (front.byte_order != kByteOrder)
    throw Error("{}: was written by a processor of the other byte order", path);
  if (front.version != kVersion) {
    throw Error("{}: has version {}, and this program reads version {}", path, front.version, kVersion);
  }
  if (bytes.size() < 2 * kPage) throw Error("{}: is truncated to {} bytes", path, bytes.size());
  IndexTrailer t{};
  std::memcpy(&t, bytes.data() + bytes.size() - sizeof t, sizeof t);
  if (t.magic != kMagic || t.file_size != bytes.size() || t.own_hash != own_hash(t)) {
    throw Error("{}: is truncated or damaged: its last page does not match", path);
  }
  description_ = unpack(t);
  if (description_.options != options) {
    throw Error("{}: was made with other options ({})", path, description_.options);
  }
  const FileStamp now = stamp_of(scene);
  // Copies and checkouts change times: then only the contents are compared. If all times are unchanged, the
  // file need not be read.
  const bool same = now == description_.source.stamp || (now.size == description_.source.stamp.size &&
                                                         content_hash(scene) == description_.source.content);
  if (!same) throw Error("{}: is stale: the scene has changed since it was made", path);

  Cutter arrays(bytes.subspan(sizeof front, bytes.size() - sizeof front - sizeof t));
  view_.gaussians = t.gaussians;
  view_.origin = description_.origin;
  view_.blocks = arrays.take<GaussianBlock>(t.blocks);
  view_.nodes = arrays.take<IndexNode>(t.nodes);
  const std::uint64_t hashed = sizeof front + view_.blocks.size_bytes() + view_.nodes.size_bytes();
  const auto table = arrays.take<std::uint64_t>((hashed + kChunk - 1) / kChunk);
  if (!arrays.fits_exactly()) throw Error("{}: is damaged: its arrays do not match its size", path);
  if (hash(table.data(), table.size_bytes()) != t.table_hash) {
    throw Error("{}: is damaged: its table of checksums does not match", path);
  }
  const std::size_t changed = first_changed_chunk(bytes.first(hashed), table);
  if (changed != table.size()) {
    throw Error("{}: is damaged: the checksum of the MiB at byte {} does not match", path, changed * kChunk);
  }
  if (!is_tree(view_)) throw Error("{}: is damaged: its nodes are not a tree", path);
}

}  // namespace palpate
