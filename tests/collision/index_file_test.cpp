// The index as a file: what is written is what is read, and nothing else is taken for it.

#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <palpate/base/error.h>
#include <palpate/collision/index_file.h>
#include <support/index_check.h>
#include <support/indexed_scene.h>
#include <support/on_every_target.h>

namespace palpate {
namespace {

using test::message_of;
using test::SceneFile;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr std::size_t kPage = 4096;

/// A scene file with an index beside it, and ways to spoil that.
class IndexFileTest : public testing::Test {
 protected:
  void SetUp() override { write(index_); }

  void write(const SceneIndex& index) { write(index.view()); }
  void write(const IndexView& view) {
    FilterReport report;
    report.total = 9;
    report.defects = {0, 1, 2, 3, 4};
    report.low_opacity = 5;
    report.below_iso = 6;
    report.over_max_scale = 7;
    report.outside_crop = 8;
    report.kept = view.gaussians;
    IndexWriter writer(path_);
    const std::size_t half = view.blocks.size() / 2;
    writer.add(view.blocks.first(half));
    writer.add(view.blocks.subspan(half));
    writer.finish(view.nodes, {{stamp_of(scene_.path()), content_hash(scene_.path())},
                               kOptions,
                               report,
                               view.gaussians,
                               view.origin});
    report_ = report;
    std::ifstream in(path_, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(in), {});
  }

  std::shared_ptr<IndexFile> open(const std::string& options = kOptions) const {
    return std::make_shared<IndexFile>(path_, scene_.path(), options);
  }
  /// Why `bytes` are no index of the scene; empty if they are.
  std::string refusal(const std::string& bytes) const {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes;
    try {
      open();
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), StartsWith(path_ + ": "));
      return error.what();
    }
    return {};
  }

  static constexpr const char* kOptions = "--opacity-min 0.1 --sigma 1";
  SceneFile scene_{20000};
  std::string path_ = scene_.path() + ".palpate";
  SceneIndex index_{scene_.scene(), {}, {}};
  FilterReport report_;
  std::string bytes_;  ///< of the index
};

TEST_F(IndexFileTest, HoldsTheIndexToTheLastBit) {
  const auto file = open();
  const SceneIndex mapped(file, {});
  test::expect_valid(mapped.view(), scene_.scene());
  EXPECT_EQ(mapped.size(), index_.size());
  EXPECT_EQ(mapped.bytes(), index_.bytes());
  for (const std::string& target : simd_targets()) {
    use_simd_target(target);
    scene_.expect_same_contacts(mapped, index_);
  }
  use_simd_target("");
}

TEST_F(IndexFileTest, SaysWhatItIsOf) {
  const auto file = open();
  const IndexDescription& d = file->description();
  EXPECT_EQ(d.options, kOptions);
  EXPECT_EQ(d.report, report_);
  EXPECT_EQ(d.gaussians, 20000U);
  EXPECT_EQ(d.source.stamp, stamp_of(scene_.path()));
  EXPECT_EQ(d.source.content, content_hash(scene_.path()));
}

// Whoever asks only that reads the first and the last page, and takes neither for what it is not.
TEST_F(IndexFileTest, SaysItsSourceOnlyIfItIsWhole) {
  const auto source_of = [&](const std::string& bytes) {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes;
    return index_source(path_);
  };
  const std::optional<IndexSource> source = source_of(bytes_);
  ASSERT_TRUE(source);
  EXPECT_EQ(source->stamp, stamp_of(scene_.path()));
  EXPECT_EQ(source->content, content_hash(scene_.path()));
  const std::size_t last = bytes_.size() - kPage;
  for (const std::size_t at : {std::size_t{3}, std::size_t{8}, std::size_t{12}, last, last + 40}) {
    std::string spoilt = bytes_;
    spoilt[at] = static_cast<char>(spoilt[at] ^ 1);
    EXPECT_FALSE(source_of(spoilt)) << "byte " << at;
  }
  EXPECT_FALSE(source_of(bytes_ + bytes_.substr(last))) << "a last page of a shorter file";
  EXPECT_FALSE(source_of(bytes_.substr(0, kPage)));
  EXPECT_FALSE(source_of(""));
  std::filesystem::remove(path_);
  EXPECT_FALSE(index_source(path_));
}

TEST_F(IndexFileTest, HasTheLayoutOfTheHeader) {
  const IndexView view = index_.view();
  const std::size_t arrays = 1024 * view.blocks.size() + 448 * view.nodes.size();
  const std::size_t chunks = (kPage + arrays + (1U << 20) - 1) >> 20;
  EXPECT_GE(chunks, 2U);
  EXPECT_EQ(bytes_.size(), kPage + arrays + 8 * chunks + kPage);
  EXPECT_EQ(bytes_.substr(0, 8), "PALPATE\n");
  EXPECT_EQ(std::memcmp(&bytes_[kPage], view.blocks.data(), view.blocks.size_bytes()), 0);
  EXPECT_EQ(
      std::memcmp(&bytes_[kPage + view.blocks.size_bytes()], view.nodes.data(), view.nodes.size_bytes()), 0);
}

TEST_F(IndexFileTest, HoldsAnOriginAndNothingAtAll) {
  GaussianScene far = scene_.scene();
  far.origin = {4.5e6, 5.4e6, 3e2};
  write(SceneIndex(far, {}, {}));
  EXPECT_EQ(open()->view().origin, far.origin);
  write(SceneIndex(GaussianScene{}, {}, {}));
  const SceneIndex nothing(open(), {});
  ContactSet set;
  nothing.query(scene_.tools().front(), set);
  EXPECT_EQ(nothing.size() + set.candidates + set.contacts.size(), 0U);
}

TEST_F(IndexFileTest, SameInputSameBytes) {
  const std::string first = bytes_;
  write(SceneIndex(scene_.scene(), {}, {}));
  EXPECT_TRUE(bytes_ == first);
}

TEST_F(IndexFileTest, RefusesWhatIsNoIndexOfItsKind) {
  std::string spoilt = bytes_;
  spoilt[3] = 'Q';
  EXPECT_THAT(refusal(spoilt), HasSubstr("is not a palpate index"));
  EXPECT_THAT(refusal("x"), HasSubstr("is not a palpate index"));
  EXPECT_THAT(refusal(scene_.bytes()), HasSubstr("is not a palpate index"));
  EXPECT_THAT(refusal(""), HasSubstr("is empty"));
  spoilt = bytes_;
  std::reverse(spoilt.begin() + 8, spoilt.begin() + 12);
  EXPECT_THAT(refusal(spoilt), HasSubstr("other byte order"));
  spoilt = bytes_;
  ++spoilt[12];
  EXPECT_THAT(refusal(spoilt), HasSubstr("version"));
  std::filesystem::remove(path_);
  EXPECT_THAT(message_of<Error>([&] { open(); }), AllOf(HasSubstr(path_), HasSubstr("No such file")));
  EXPECT_TRUE(refusal(bytes_).empty()) << "the sound one is taken";
}

TEST_F(IndexFileTest, RefusesAFileThatIsCutAnywhere) {
  test::Random random(702);
  std::vector<std::size_t> lengths{1,
                                   7,
                                   8,
                                   15,
                                   16,
                                   17,
                                   kPage - 1,
                                   kPage,
                                   kPage + 1,
                                   2 * kPage - 1,
                                   2 * kPage,
                                   bytes_.size() - kPage - 8,
                                   bytes_.size() - kPage,
                                   bytes_.size() - 8,
                                   bytes_.size() - 1};
  for (int i = 0; i < 100; ++i)
    lengths.push_back(static_cast<std::size_t>(random.uniform(1, static_cast<double>(bytes_.size()))));
  for (const std::size_t length : lengths) EXPECT_FALSE(refusal(bytes_.substr(0, length)).empty()) << length;
  EXPECT_THAT(refusal(bytes_.substr(0, bytes_.size() / 2)), HasSubstr("truncated or damaged"));
  EXPECT_THAT(refusal(bytes_ + "x"), HasSubstr("truncated or damaged"));
  EXPECT_THAT(refusal(bytes_ + bytes_), HasSubstr("truncated or damaged"));
  // A hole in the middle, and a page too many.
  EXPECT_FALSE(refusal(bytes_.substr(0, 3 * kPage) + bytes_.substr(4 * kPage)).empty());
  EXPECT_FALSE(refusal(bytes_.substr(0, 3 * kPage) + bytes_.substr(2 * kPage)).empty());
}

TEST_F(IndexFileTest, RefusesAnyBitThatIsFlipped) {
  test::Random random(703);
  const std::size_t arrays_end = bytes_.size() - kPage - 16;
  std::vector<std::size_t> places;
  const auto draw = [&](std::size_t begin, std::size_t end, int count) {
    for (int i = 0; i < count; ++i)
      places.push_back(begin +
                       static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(end - begin))));
  };
  for (std::size_t k = 0; k < 16; ++k) places.push_back(k);  // magic, byte order, version
  draw(16, kPage, 50);                                       // the rest of the first page
  draw(kPage, arrays_end, 300);                              // blocks and nodes
  for (std::size_t k = arrays_end; k < bytes_.size() - kPage; ++k)
    places.push_back(k);  // the table of checksums
  for (std::size_t k = 0; k < 400; ++k)
    places.push_back(bytes_.size() - kPage + k);  // the last page's numbers
  draw(bytes_.size() - kPage, bytes_.size(), 200);
  std::string spoilt = bytes_;
  for (const std::size_t at : places) {
    const char bit = static_cast<char>(1 << random.integer(0, 7));
    spoilt[at] = static_cast<char>(spoilt[at] ^ bit);
    {
      std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
      file.seekp(static_cast<std::streamoff>(at));
      file.put(spoilt[at]);
    }
    EXPECT_THROW(open(), Error) << "byte " << at << " of " << bytes_.size();
    spoilt[at] = bytes_[at];
    std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(at));
    file.put(spoilt[at]);
  }
  EXPECT_NO_THROW(open()) << "all is as it was";
}

TEST_F(IndexFileTest, SaysWhereItIsChanged) {
  std::string spoilt = bytes_;
  const std::size_t at = (1U << 20) + 1000;
  ASSERT_LT(at, bytes_.size() - kPage);
  spoilt[at] = static_cast<char>(spoilt[at] ^ 1);
  EXPECT_THAT(refusal(spoilt), AllOf(HasSubstr("checksum"), HasSubstr("byte 1048576")));
}

TEST_F(IndexFileTest, RefusesOtherOptionsAndNamesThem) {
  EXPECT_THAT(message_of<Error>([&] { open("--opacity-min 0.1 --sigma 2"); }),
              AllOf(StartsWith(path_), HasSubstr("other options"), HasSubstr(kOptions)));
  EXPECT_NO_THROW(open());
}

TEST_F(IndexFileTest, RefusesAnotherStateOfTheScene) {
  std::string changed = scene_.bytes();
  const FileStamp before = stamp_of(scene_.path());
  ::usleep(20'000);
  changed[changed.size() - 3] = static_cast<char>(changed[changed.size() - 3] ^ 1);
  std::ofstream(scene_.path(), std::ios::binary | std::ios::in) << changed;  // in place
  scene_.touch(before.modified_ns);
  ASSERT_EQ(stamp_of(scene_.path()).size, before.size);
  EXPECT_THAT(message_of<Error>([&] { open(); }), AllOf(StartsWith(path_), HasSubstr("stale"))) << "content";
  std::ofstream(scene_.path(), std::ios::binary | std::ios::app) << "x";
  EXPECT_THAT(message_of<Error>([&] { open(); }), AllOf(StartsWith(path_), HasSubstr("stale"))) << "size";
  std::filesystem::remove(scene_.path());
  EXPECT_THROW(open(), Error);
}

TEST_F(IndexFileTest, TakesACopyOfTheScene) {
  const std::string bytes = scene_.bytes();
  std::filesystem::remove(scene_.path());
  std::ofstream(scene_.path(), std::ios::binary) << bytes;
  scene_.touch(1'000'000'000);
  EXPECT_NO_THROW(open());
}

/// The children of a node, in its slots from the first on: nodes, or blocks as leaf() makes them. 0 is none.
using Children = std::vector<std::uint32_t>;

std::uint32_t leaf(std::uint32_t block) { return block | IndexNode::kLeaf; }

IndexNode node_of(const Children& children) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  IndexNode node;
  for (std::size_t slot = 0; slot < kIndexWidth; ++slot) {
    node.child[slot] = slot < children.size() ? children[slot] : 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      node.low[axis][slot] = node.child[slot] != 0 ? -1.0F : kInfinity;
      node.high[axis][slot] = node.child[slot] != 0 ? 1.0F : -kInfinity;
    }
  }
  return node;
}

/// Index files whose checksums fit, whatever their nodes are.
class IndexFileOfNodes : public IndexFileTest {
 protected:
  /// Of these nodes, and the first `blocks` blocks of the index.
  std::string refusal_of(const std::vector<IndexNode>& nodes, std::size_t blocks) {
    IndexView view = index_.view();
    view.nodes = nodes;
    view.blocks = view.blocks.first(blocks);
    write(view);
    return refusal(bytes_);
  }
  std::string refusal_of_tree(const std::vector<Children>& tree, std::size_t blocks) {
    std::vector<IndexNode> nodes;
    for (const Children& children : tree) nodes.push_back(node_of(children));
    return refusal_of(nodes, blocks);
  }
};

TEST_F(IndexFileOfNodes, TakesATree) {
  EXPECT_EQ(refusal_of_tree({}, 0), "");
  EXPECT_EQ(refusal_of_tree({{leaf(0)}}, 1), "");
  EXPECT_EQ(refusal_of_tree({{1, 2}, {leaf(0), leaf(1)}, {leaf(2), 3}, {leaf(3)}}, 4), "");
  EXPECT_EQ(refusal_of_tree({{2, 0, 1}, {leaf(3), leaf(0)}, {0, leaf(2), leaf(1)}}, 4), "") << "in any order";
}

TEST_F(IndexFileOfNodes, RefusesWhatIsSharedUnreachableOrACycle) {
  const std::pair<const char*, std::vector<Children>> cases[] = {
      {"a node twice in one node", {{1, 1}, {leaf(0), leaf(1)}}},
      {"a node in two nodes", {{1, 2}, {3, leaf(0)}, {3}, {leaf(1)}}},
      {"a node of two depths", {{1, 2}, {2}, {leaf(0), leaf(1)}}},
      {"a block twice in one node", {{leaf(0), leaf(1), leaf(0)}}},
      {"a block in two nodes", {{1, 2}, {leaf(0), leaf(1)}, {leaf(1)}}},
      {"a node without a parent", {{1}, {leaf(0)}, {leaf(1)}}},
      {"a block without a parent", {{leaf(1)}}},
      {"no nodes at all", {}},
      {"its own parent", {{1}, {leaf(0), leaf(1), 1}}},
      {"its parent's parent", {{1}, {2, leaf(0)}, {leaf(1), 1}}},
      {"two that have each other", {{leaf(0), leaf(1)}, {2}, {1}}},
      {"no such node", {{leaf(0), leaf(1), 1}}},
      {"no such block", {{leaf(0), leaf(1), leaf(2)}}},
  };
  for (const auto& [what, nodes] : cases)
    EXPECT_THAT(refusal_of_tree(nodes, 2), HasSubstr("its nodes are not a tree")) << what;
}

// Sixteen ways down from each of 62 levels to the next: no walk would end.
TEST_F(IndexFileOfNodes, RefusesLevelsThatShareTheirChildren) {
  constexpr std::uint32_t kLevels = 62;
  std::vector<Children> nodes;
  for (std::uint32_t level = 0; level < kLevels; ++level)
    nodes.emplace_back(kIndexWidth, level + 1 < kLevels ? level + 1 : leaf(0));
  EXPECT_THAT(refusal_of_tree(nodes, 1), HasSubstr("its nodes are not a tree"));
  for (Children& children : nodes) children.resize(1);
  EXPECT_EQ(refusal_of_tree(nodes, 1), "") << "as a chain they are a tree";
}

TEST_F(IndexFileOfNodes, RefusesATreeThatIsTooDeep) {
  std::vector<Children> nodes;
  for (std::uint32_t level = 0; level < kMaxIndexDepth; ++level)
    nodes.push_back({level + 1 < kMaxIndexDepth ? level + 1 : leaf(0)});
  EXPECT_EQ(refusal_of_tree(nodes, 1), "");
  nodes.back() = {kMaxIndexDepth};
  nodes.push_back({leaf(0)});
  EXPECT_THAT(refusal_of_tree(nodes, 1), HasSubstr("its nodes are not a tree"));
}

// No walk would get to them.
TEST_F(IndexFileOfNodes, RefusesAChildInABoxThatIsEmpty) {
  for (const float high : {-2.0F, std::numeric_limits<float>::quiet_NaN()}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::vector<IndexNode> nodes{node_of({1, leaf(0)}), node_of({leaf(1)})};
      ASSERT_EQ(refusal_of(nodes, 2), "");
      nodes[axis % 2].high[axis][0] = high;
      EXPECT_THAT(refusal_of(nodes, 2), HasSubstr("its nodes are not a tree")) << "axis " << axis;
    }
  }
}

TEST(ContentHash, TellsFilesApart) {
  std::string bytes((16 << 20) + 5, 'a');  // more than one of its parts
  const auto hash_of = [](const std::string& text) { return content_hash(test::TemporaryFile(text).path()); };
  const std::uint64_t hash = hash_of(bytes);
  EXPECT_EQ(hash_of(bytes), hash);
  for (const std::size_t at :
       {std::size_t{0}, std::size_t{16 << 20}, bytes.size() - 1, std::size_t{300'000}}) {
    std::string changed = bytes;
    changed[at] = 'b';
    EXPECT_NE(hash_of(changed), hash) << at;
  }
  std::string swapped = bytes;
  swapped[1] = 'b';
  std::string other = bytes;
  other[(16 << 20) + 1] = 'b';
  EXPECT_NE(hash_of(swapped), hash_of(other));
  EXPECT_NE(hash_of(bytes + "a"), hash);
  EXPECT_NE(hash_of(""), hash_of("a"));
}

TEST(IndexOptions, AreEqualOnlyIfTheIndicesAre) {
  const Similarity here, there{2.0, Eigen::Quaterniond(0, 1, 0, 0), {1, 2, 3}},
      mirrored{1.0, Eigen::Quaterniond::Identity(), {0, 0, 0}, true};
  SceneFilter plain;
  EXPECT_EQ(index_options(plain, here), index_options(plain, there)) << "the registration does not matter";
  std::vector<SceneFilter> filters(9);
  filters[1].opacity_min = 0.2;
  filters[2].opacity_min = std::nextafter(0.2, 1.0);
  filters[3].sigma = 3.0;
  filters[4].iso = 0.2;
  filters[5].max_scale = 1.0;
  filters[6].crop_box = Eigen::AlignedBox3d(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 2, 3));
  filters[7].crop_sphere = SceneFilter::Sphere{{0, 0, 0}, 1.0};
  filters[8].crop_sphere = SceneFilter::Sphere{{0, 0, 1}, 1.0};
  for (std::size_t a = 0; a < filters.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_NE(index_options(filters[a], here), index_options(filters[b], here)) << a << ", " << b;
    const bool by_place = a >= 5;
    for (const Similarity& other : {there, mirrored})
      EXPECT_EQ(index_options(filters[a], here) == index_options(filters[a], other), !by_place) << a;
  }
  SceneFilter iso_and_sigma = filters[4];
  iso_and_sigma.sigma = 7.0;  // which iso replaces
  EXPECT_EQ(index_options(iso_and_sigma, here), index_options(filters[4], here));
}

}  // namespace
}  // namespace palpate
