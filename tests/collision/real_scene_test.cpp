// Captured scenes through reader, filter, registration and index, against a reader and an overlap test of
// this file's own in extended precision. Needs PALPATE_SCENES, a folder with seal.ply and seal.splat.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <palpate/collision/scene_index.h>
#include <palpate/scene/load_scene.h>
#include <support/brute_force.h>
#include <support/k_oracle.h>
#include <support/parallel.h>
#include <support/random_pairs.h>
#include <support/wide_gaussian.h>

namespace palpate {
namespace {

using test::PairOracle;
using test::Wide;
using test::WideGaussian;

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

float float_at(const std::string& bytes, std::size_t offset) {
  float v = 0;
  std::memcpy(&v, bytes.data() + offset, sizeof v);
  return v;
}

/// A .ply of one element of float properties, little-endian.
std::vector<WideGaussian> read_ply(const std::string& path) {
  const std::string bytes = bytes_of(path);
  const std::size_t body = bytes.find("end_header\n") + 11;
  std::istringstream header(bytes.substr(0, body));
  std::map<std::string, std::size_t> offset;
  std::size_t count = 0;
  for (std::string word; header >> word;) {
    if (word == "vertex") header >> count;
    if (word == "property") {
      std::string name;
      header >> word >> name;
      offset.emplace(name, 4 * offset.size());
    }
  }
  std::vector<WideGaussian> result(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = [&](const std::string& name) {
      return static_cast<Wide>(float_at(bytes, body + i * 4 * offset.size() + offset.at(name)));
    };
    WideGaussian& g = result[i];
    g.position = {value("x"), value("y"), value("z")};
    g.sigma = {std::exp(value("scale_0")), std::exp(value("scale_1")), std::exp(value("scale_2"))};
    g.q = {value("rot_0"), value("rot_1"), value("rot_2"), value("rot_3")};
    g.alpha = 1 / (1 + std::exp(-value("opacity")));
  }
  return result;
}

std::vector<WideGaussian> read_splat(const std::string& path) {
  const std::string bytes = bytes_of(path);
  std::vector<WideGaussian> result(bytes.size() / 32);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const std::size_t at = 32 * i;
    const auto byte = [&](std::size_t k) {
      return static_cast<Wide>(static_cast<unsigned char>(bytes[at + k]));
    };
    for (std::size_t k = 0; k < 3; ++k) {
      result[i].position[k] = float_at(bytes, at + 4 * k);
      result[i].sigma[k] = float_at(bytes, at + 12 + 4 * k);
    }
    result[i].alpha = byte(27) / 255;
    for (std::size_t k = 0; k < 4; ++k) result[i].q[k] = (byte(28 + k) - 128) / 128;
  }
  return result;
}

/// Eqs. 2-3: what collides, in the world.
struct WorldSolids {
  std::vector<test::Solid<Wide>> solids;
  std::vector<std::uint32_t> id;
  std::vector<Eigen::Vector3d> center;
  std::vector<double> radius;
};

WorldSolids solids_of(const std::vector<WideGaussian>& gaussians, const SceneFilter& filter,
                      const Similarity& s) {
  WorldSolids scene;
  for (std::size_t i = 0; i < gaussians.size(); ++i) {
    const WideGaussian& g = gaussians[i];
    if (!(g.alpha > static_cast<Wide>(filter.opacity_min))) continue;
    const test::Solid<Wide> solid = test::solid_of(g, filter.sigma, s);
    const auto d = [](Wide v) { return static_cast<double>(v); };
    scene.solids.push_back(solid);
    scene.id.push_back(static_cast<std::uint32_t>(i));
    scene.center.emplace_back(d(solid.center[0]), d(solid.center[1]), d(solid.center[2]));
    scene.radius.push_back(d(filter.sigma * s.scale * std::max({g.sigma[0], g.sigma[1], g.sigma[2]})));
  }
  return scene;
}

struct ContactTally {
  std::size_t contacts = 0, undecided = 0, missed = 0, extra = 0;
  double worst = 0.0;
};

/// Compares one pose.
void check_pose(const WorldSolids& truth, const Ellipsoid& tool, const std::vector<Contact>& found,
                ContactTally& tally) {
  constexpr Wide kUndecided = 1e-9;
  const test::Solid<Wide> wide_tool(tool);
  auto next = found.begin();
  for (std::size_t i = 0; i < truth.solids.size(); ++i) {
    const bool is_found = next != found.end() && next->id == truth.id[i];
    const double reach = 1.0001 * (truth.radius[i] + tool.radius());
    if (!is_found && (truth.center[i] - tool.center).squaredNorm() > reach * reach) continue;
    const Wide k = PairOracle<Wide>(wide_tool, truth.solids[i]).k_min(-kUndecided);
    tally.undecided += std::abs(k) < kUndecided;
    tally.missed += k >= kUndecided && !is_found;
    tally.extra += k <= -kUndecided && is_found;
    if (is_found) {
      if (k > -kUndecided)
        tally.worst =
            std::max(tally.worst, std::abs(static_cast<double>(k - static_cast<Wide>(next->k_min))));
      ++tally.contacts;
      ++next;
    }
  }
  EXPECT_TRUE(next == found.end()) << "a contact with a Gaussian that the filter drops";
}

struct Case {
  const char* file;
  double sigma;
  Similarity world_from_scene;
};

/// How a case is called in the list of tests.
void PrintTo(const Case& c, std::ostream* out) {
  *out << c.file << " at " << c.sigma << " sigma" << (c.world_from_scene.scale == 1.0 ? "" : ", registered");
}

class RealScene : public testing::TestWithParam<Case> {};

TEST_P(RealScene, HasNoMissedAndNoExtraContacts) {
  const char* folder = std::getenv("PALPATE_SCENES");
  if (folder == nullptr || *folder == '\0')
    GTEST_SKIP() << "set PALPATE_SCENES to the folder of seal.ply and seal.splat";
  const Case& c = GetParam();
  const std::string path = std::string(folder) + "/" + c.file;
  if (!std::ifstream(path)) GTEST_SKIP() << path << " is not there";

  SceneFilter filter;
  filter.sigma = c.sigma;
  const bool is_ply = path.ends_with(".ply");
  const WorldSolids truth = solids_of(is_ply ? read_ply(path) : read_splat(path), filter, c.world_from_scene);
  const SceneIndex index(load_scene(path), filter, c.world_from_scene);
  EXPECT_EQ(index.size(), truth.id.size());

  constexpr std::size_t kPoses = 2000;
  std::vector<ContactTally> tallies(test::kThreads);
  test::on_threads([&](std::size_t thread) {
    ContactSet found;
    for (std::size_t i = thread; i < kPoses; i += test::kThreads) {
      test::Random random(90'000'000 + i);
      const auto near =
          static_cast<std::size_t>(random.integer(0, static_cast<int>(truth.center.size()) - 1));
      const Eigen::Vector3d center = truth.center[near] + random.vector(0.0, 0.05);
      const Ellipsoid tool = Ellipsoid::from_semi_axes({center, random.rotation()}, {0.02, 0.02, 0.04});
      index.query(tool, found);
      check_pose(truth, tool, test::in_order(found.contacts), tallies[thread]);
    }
  });
  ContactTally all;
  for (const ContactTally& t : tallies) {
    all.contacts += t.contacts;
    all.undecided += t.undecided;
    all.missed += t.missed;
    all.extra += t.extra;
    all.worst = std::max(all.worst, t.worst);
  }
  std::printf(
      "  %s: %zu Gaussians, %zu contacts in %zu poses, %zu within 1e-9 of touching, worst |dK_min| %.1e\n",
      c.file, index.size(), all.contacts, kPoses, all.undecided, all.worst);
  RecordProperty("worst_dk", testing::PrintToString(all.worst));
  EXPECT_GT(all.contacts, 10U * kPoses);
  EXPECT_EQ(all.missed, 0U);
  EXPECT_EQ(all.extra, 0U);
  EXPECT_LE(all.worst, 1e-9);
}

const Similarity kRegistered{
    0.6180339887, Eigen::Quaterniond(0.5, -0.7, 0.1, 0.3).normalized(), {3.25, -41.5, 1.125}};

INSTANTIATE_TEST_SUITE_P(Seal, RealScene,
                         testing::Values(Case{"seal.ply", 1.0, {}}, Case{"seal.ply", 2.5, {}},
                                         Case{"seal.ply", 1.0, kRegistered}, Case{"seal.splat", 1.0, {}},
                                         Case{"seal.splat", 2.5, {}}, Case{"seal.splat", 2.5, kRegistered}));

}  // namespace
}  // namespace palpate
