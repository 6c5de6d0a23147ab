/// \file
/// A scene file in a folder of its own, for the tests of index files.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <palpate/base/file.h>
#include <palpate/collision/scene_index.h>
#include <palpate/scene/load_scene.h>
#include <palpate/scene/ply_writer.h>
#include <support/brute_force.h>
#include <support/random_scenes.h>
#include <support/temporary_file.h>

namespace palpate::test {

/// `count` splats near the unit sphere as garden.ply, and tools that touch them.
class SceneFile {
 public:
  explicit SceneFile(std::size_t count = 3000, std::uint64_t seed = 701) : file_("", "garden.ply") {
    write(count, seed);
  }

  /// Writes other splats to it.
  void write(std::size_t count, std::uint64_t seed) {
    Random random(seed);
    write_ply(in_logarithms(scene_of(sphere_of_splats(random, count))), path(), "");
    scene_ = load_scene(path());
    tools_ = tools_at_sphere(random, 50);
  }

  const std::string& path() const { return file_.path(); }
  const GaussianScene& scene() const { return scene_; }
  const std::vector<Ellipsoid>& tools() const { return tools_; }
  std::string bytes() const { return file_.bytes(); }
  std::filesystem::path folder() const { return file_.folder(); }

  /// Names of the folder's files.
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder()))
      names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }

  /// Sets the time of the last change to `ns` after 1970.
  void touch(std::int64_t ns) const {
    const timespec times[2] = {{0, UTIME_OMIT}, {ns / 1'000'000'000, ns % 1'000'000'000}};
    ASSERT_EQ(::utimensat(AT_FDCWD, path().c_str(), times, 0), 0);
  }

  /// Expects the contacts of `index` to be, to the last bit, those of `reference`. There must be some.
  void expect_same_contacts(const SceneIndex& index, const SceneIndex& reference) const {
    ContactSet a, b;
    std::size_t seen = 0;
    for (const Ellipsoid& tool : tools_) {
      index.query(tool, a);
      reference.query(tool, b);
      expect_equal(a.contacts, b.contacts);
      EXPECT_EQ(a.candidates, b.candidates);
      EXPECT_EQ(a.filtered, b.filtered);
      seen += b.contacts.size();
    }
    EXPECT_GT(seen, 5U);
  }

 private:
  TemporaryFile file_;
  GaussianScene scene_;
  std::vector<Ellipsoid> tools_;
};

/// A folder that nobody may write to, for a scope.
class ReadOnly {
 public:
  explicit ReadOnly(std::filesystem::path folder) : folder_(std::move(folder)) { set(0555); }
  ~ReadOnly() { set(0755); }
  ReadOnly(const ReadOnly&) = delete;
  ReadOnly& operator=(const ReadOnly&) = delete;

 private:
  void set(unsigned mode) const { std::filesystem::permissions(folder_, std::filesystem::perms(mode)); }

  std::filesystem::path folder_;
};

}  // namespace palpate::test
