#include <palpate/collision/contact_columns.h>

#include <tbb/parallel_for.h>

namespace palpate {
namespace {

/// Calls `call` for every column with one row per contact.
template <class Columns, class Call>
void for_each_column(Columns& columns, const Call& call) {
  call(columns.id, &Contact::id);
  call(columns.k_min, &Contact::k_min);
  call(columns.lambda, &Contact::lambda);
  call(columns.opacity, &Contact::opacity);
  call(columns.center, &Contact::center);
  call(columns.point, &Contact::point);
  call(columns.normal, &Contact::normal);
  call(columns.depth, &Contact::depth);
  call(columns.extent, &Contact::extent);
}

}  // namespace

Contact ContactColumns::contact(std::size_t i) const {
  Contact found;
  for_each_column(*this, [&](const auto& column, auto field) { found.*field = column[i]; });
  return found;
}

void ContactColumns::clear() {
  first.resize(1);
  candidates.clear();
  filtered.clear();
  for_each_column(*this, [](auto& column, auto) { column.clear(); });
}

void ContactColumns::append(std::span<const ContactSet> sets) {
  const std::size_t before = tools();
  for (const ContactSet& set : sets) {
    first.push_back(first.back() + set.contacts.size());
    candidates.push_back(set.candidates);
    filtered.push_back(set.filtered);
  }
  for_each_column(*this, [&](auto& column, auto) { column.resize(first.back()); });
  tbb::parallel_for(std::size_t{0}, sets.size(), [&](std::size_t k) {
    const std::vector<Contact>& contacts = sets[k].contacts;
    for_each_column(*this, [&, row = first[before + k]](auto& column, auto field) {
      for (std::size_t i = 0; i < contacts.size(); ++i) column[row + i] = contacts[i].*field;
    });
  });
}

}  // namespace palpate
