/// \file
/// Results of `palpate bench`, as text and JSON.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <palpate/haptics/tool.h>
#include <palpate/report/ordered_json.h>
#include <palpate/study/open_timing.h>
#include <palpate/study/query_timing.h>

namespace palpate {

struct BenchFigures {
  std::string scene;           ///< file
  std::string path;            ///< file; empty for a generated path
  std::string pipeline, simd;  ///< as in the options; the instruction set used
  std::string model;
  std::string tool_name;  ///< short description
  Tool tool;
  OpenFigures open;
  int rounds = 0;
  std::vector<PoseFigures> poses;
  bool tracked = false;  ///< PoseFigures::tracked was measured
  int threads = 0;
  double queries_per_second = 0.0;  ///< of the poses in contact; of all if there are none

  std::size_t contact_poses() const;
};

/// One kind of query and its times, one for each pose measured. Unit: [us].
struct Phase {
  const char* key;   ///< in JSON
  const char* name;  ///< in text
  std::vector<double> times;
};

/// query_contact, query_free, tracker_contact and force_contact.
std::vector<Phase> phases_of(const BenchFigures& figures);

/// Times that the histogram shows: of the fresh queries in contact, or of all if nothing is touched.
std::vector<double> histogram_times(const BenchFigures& figures);

/// Draws a histogram of histogram_times(). \returns an SVG document.
std::string bench_histogram(const BenchFigures& figures);

/// Returns an object with these keys, all always present:
///
///     machine             string     processor, cores, compiler, date
///     scene               string     file
///     scene_bytes         integer    its size
///     gaussians           integer    number that can be touched
///     pipeline, simd      string
///     model               string
///     tool                [object]   its parts, see tool_json()
///     open                object     seconds; origin: "index file", "new index file" or "memory";
///                                    remarks: [string];
///                                    index_bytes, bytes_per_gaussian: of the index, null if unknown;
///                                    peak_rss_bytes: largest resident set so far
///     path                string     file, null for a generated path
///     poses               integer
///     contact_poses       integer    poses in contact
///     rounds              integer    repetitions; the least time of each pose counts
///     latency_us          object     query_contact, query_free, tracker_contact, force_contact: each an
///                                    object of count, p50, p99, p99.9 and max, or null without such poses
///     sizes               object     contacts, filtered, candidates of the poses in contact: median, max;
///                                    or null
///     throughput          object     threads, queries_per_second, in_contact: true if of poses in contact,
///                                    false if of all
OrderedJson bench_json(const BenchFigures& figures);

/// Returns a table, followed by a histogram if `with_histogram`.
std::string bench_text(const BenchFigures& figures, bool with_histogram);

}  // namespace palpate
