/// \file
/// Out-of-core partitioning of records, for a scene that does not fit memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <palpate/base/file.h>
#include <palpate/collision/index_builder.h>
#include <palpate/collision/space_partition.h>

namespace palpate {

/// One temporary file in which every part has a chain of extents. Buffers one extent per part in memory.
class RecordSpill {
 public:
  /// \throws Error if `folder` cannot be written.
  RecordSpill(const std::string& folder, const SpacePartition& partition);

  /// Appends every record to its part. \throws Error when the disk is full.
  void add(std::span<const GaussianRecord> records);

  /// The records of a part, in the order of insertion. \throws Error.
  std::vector<GaussianRecord> read(std::size_t part);

 private:
  /// Records per extent, 0.8 MB: large enough for efficient disk access, small enough to buffer one per part.
  static constexpr std::size_t kExtent = std::size_t{1} << 14;

  struct Part {
    std::vector<GaussianRecord> open;    ///< not written yet
    std::vector<std::uint64_t> extents;  ///< offsets in the file
  };
  void write(Part& part);

  TemporaryFile file_;
  const SpacePartition& partition_;
  std::vector<Part> parts_;
  std::uint64_t end_ = 0;
};

}  // namespace palpate
