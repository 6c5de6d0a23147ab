#include <palpate/collision/record_spill.h>

namespace palpate {

RecordSpill::RecordSpill(const std::string& folder, const SpacePartition& partition)
    : file_(folder), partition_(partition), parts_(partition.parts()) {
  for (Part& part : parts_) part.open.reserve(kExtent);
}

void RecordSpill::add(std::span<const GaussianRecord> records) {
  for (const GaussianRecord& record : records) {
    Part& part = parts_[partition_.part_of(record.position)];
    part.open.push_back(record);
    if (part.open.size() == kExtent) write(part);
  }
}

void RecordSpill::write(Part& part) {
  const std::span<const GaussianRecord> records = part.open;
  file_.write(end_, {reinterpret_cast<const char*>(records.data()), records.size_bytes()});
  part.extents.push_back(end_);
  end_ += records.size_bytes();
  part.open.clear();
}

std::vector<GaussianRecord> RecordSpill::read(std::size_t index) {
  const Part& part = parts_[index];
  std::vector<GaussianRecord> records(part.extents.size() * kExtent);
  for (std::size_t i = 0; i < part.extents.size(); ++i) {
    file_.read(part.extents[i],
               {reinterpret_cast<char*>(&records[i * kExtent]), kExtent * sizeof(GaussianRecord)});
  }
  records.insert(records.end(), part.open.begin(), part.open.end());
  return records;
}

}  // namespace palpate
