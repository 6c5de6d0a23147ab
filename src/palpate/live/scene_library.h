/// \file
/// The scenes that a page may open.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// Scenes in the folders that were given at the start, the one that was felt first, those that were handed
/// over, and the built-in one; nothing else, so that no page reads any other file. Any thread.
class SceneLibrary {
 public:
  /// \param folders looked through two levels deep \param first SceneConfig::path of the scene that is felt
  /// first \param option that named the folders, for messages \throws Error for a folder that is none.
  SceneLibrary(const std::vector<std::string>& folders, std::string first,
               std::string_view option = "--scenes");
  /// Takes away what was handed over.
  ~SceneLibrary();
  SceneLibrary(const SceneLibrary&) = delete;
  SceneLibrary& operator=(const SceneLibrary&) = delete;

  struct Entry {
    std::string id;            ///< for path_of()
    std::string name;          ///< for people
    std::uint64_t bytes = 0;   ///< 0: it is not a file
    std::string refusal = {};  ///< why it cannot be read, and what to do; empty: it can
  };
  /// Looks at the disk. At most kMost, sorted by folder and name.
  std::vector<Entry> list() const;
  /// SceneConfig::path of an entry of list(), as it is now. \throws Error if there is none of that id, or it
  /// cannot be read.
  std::string path_of(std::string_view id) const;

  /// A new place for a file of `bytes` bytes that is called `name`, in a folder of its own that nobody else
  /// may read. \throws Error if its format cannot be read, or there is no room for it.
  std::string place_for(std::string_view name, std::uint64_t bytes);
  /// That file is whole: it is listed, and those handed over before go, but for `kept`. \param kept a path
  void have(const std::string& path, const std::string& kept);
  /// Or it is not: it goes.
  void drop(const std::string& path);

  static constexpr std::size_t kMost = 500;
  static constexpr std::uint64_t kRoom = std::uint64_t{256} << 20;  ///< bytes that stay free on the disk

 private:
  struct Found {
    Entry entry;
    std::string path;
  };
  std::vector<Found> find() const;

  std::vector<std::filesystem::path> folders_;  ///< without links
  std::string first_;
  mutable std::mutex mutex_;  ///< of what follows
  std::filesystem::path own_;
  std::size_t count_ = 0;            ///< of the files that have had a place there
  std::vector<std::string> handed_;  ///< over, the newest last
};

/// Why a scene file of that name cannot be read, and how it is converted; empty where nothing speaks against
/// it.
std::string refusal_of_format(std::string_view name);

}  // namespace palpate
