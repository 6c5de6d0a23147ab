/// \file
/// Chunked scene reader with bounded memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include <palpate/base/progress.h>
#include <palpate/scene/gaussian_scene.h>

namespace palpate {

/// Reads a scene file from front to back. Holds only the requested chunk and a few buffers, so that a scene
/// may be larger than memory. One thread at a time; internally, the rows of binary files are decoded in
/// parallel on the caller's oneTBB arena.
class SceneReader {
 public:
  /// Gaussians in every chunk but the last: about 8 MB.
  static constexpr std::size_t kChunk = std::size_t{1} << 17;

  virtual ~SceneReader() = default;
  SceneReader(const SceneReader&) = delete;
  SceneReader& operator=(const SceneReader&) = delete;

  /// Metadata of the whole file (source, format, encodings, sh_degree, origin), without Gaussians.
  /// trailing_bytes is known once next() has returned false.
  const GaussianScene& description() const { return description_; }

  /// Number of Gaussians in the file.
  std::uint64_t count() const { return count_; }

  /// Replaces `chunk` by the next Gaussians in file order, ids continuing; returns false, with an empty
  /// chunk, at the end. Arrays that the file lacks (colour, filter_3d) are empty in every chunk. \throws
  /// Error if the file is found to be damaged or truncated; data after the Gaussians is checked at the end.
  /// The reader is unusable after an error.
  bool next(GaussianScene& chunk);

 protected:
  /// \param description without Gaussians
  SceneReader(GaussianScene description, std::uint64_t count, Progress progress);

 private:
  /// Fills `chunk`, whose arrays except the optional ones are already sized, with the Gaussians from row
  /// `first` on. Called with consecutive chunks.
  virtual void read(std::uint64_t first, GaussianScene& chunk) = 0;

  /// Checks the data after the last Gaussian; returns the number of unexplained bytes. Called once.
  virtual std::uint64_t read_end() = 0;

  GaussianScene description_;
  std::uint64_t count_;
  std::uint64_t done_ = 0;
  bool ended_ = false;
  Progress progress_;
};

/// Opens a scene file. The format is detected from its first bytes, and from the extension only for a format
/// without a signature (`.splat`):
///   - INRIA `.ply` and its relatives, see ply_reader.h;
///   - `.splat`, see splat_reader.h.
/// Positions that may not fit single precision (.ply of type double or int) are read once here, to find
/// GaussianScene::origin; nothing else is read twice.
/// \throws Error for anything that is not a scene of at least one Gaussian, naming the file, the
/// offset, property or row, and what to do.
std::unique_ptr<SceneReader> open_scene(const std::string& path, const Progress& progress = {});

/// Checks the beginning of a scene file: its format, and the header of a .ply. \throws Error as open_scene()
/// does.
void check_beginning(const std::string& path);

/// Reads all remaining Gaussians. \throws Error as SceneReader::next() does.
GaussianScene read_all(SceneReader& reader);

}  // namespace palpate
