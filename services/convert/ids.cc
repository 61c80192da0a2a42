#include "services/convert/ids.h"

#include "services/convert/errors.h"
#include "services/convert/limits.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

template <typename Id>
absl::Status CheckAllOwned(const std::vector<Id>& ids, LocalMapId owner, absl::string_view field) {
  for (const Id& id : ids) {
    if (id.local_map != owner) {
      return absl::PermissionDeniedError(absl::StrCat(
          field, " names ", ToString(id), ", which is not of local map ", ToString(owner)));
    }
  }
  return absl::OkStatus();
}

}  // namespace

SlotWriter::SlotWriter(MapTable* table, LocalMapId own) : table_(table) {
  if (own.IsValid()) slots_[own] = next_++;
}

uint32_t SlotWriter::Slot(LocalMapId local_map) {
  if (!local_map.IsValid()) return 0;
  const auto [it, added] = slots_.try_emplace(local_map, next_);
  if (added) {
    table_->Add(local_map.value);
    ++next_;
  }
  return it->second;
}

void IdColumnWriter::AddIndex(uint32_t slot, int64_t index) {
  const int count = column_->index_deltas_size();
  // The column of slots begins with the first slot that isn't 1.
  if (slot != 1 && column_->slots_size() == 0) column_->mutable_slots()->Resize(count, 1);
  if (slot != 1 || column_->slots_size() > 0) column_->add_slots(slot);
  column_->add_index_deltas(index - last_);
  last_ = index;
}

absl::StatusOr<SlotReader> SlotReader::Create(const MapTable& table, LocalMapId own) {
  if (table.size() > kMaxLocalMapsOfMessage) {
    return OutOfRange("number of local maps", table.size(), 0, kMaxLocalMapsOfMessage);
  }
  SlotReader reader;
  reader.maps_.push_back({});
  if (own.IsValid()) reader.maps_.push_back(own);
  for (const uint64_t value : table) {
    if (value == 0) return absl::InvalidArgumentError("a local map of the table is 0");
    reader.maps_.push_back({value});
  }
  return reader;
}

absl::StatusOr<LocalMapId> SlotReader::LocalMap(uint32_t slot) const {
  if (slot >= maps_.size()) return OutOfRange("slot", slot, size_t{0}, maps_.size() - 1);
  return maps_[slot];
}

template <typename Id>
absl::StatusOr<Id> SlotReader::Ref(const v1::ItemRef& ref) const {
  Id id;
  ASSIGN_OR_RETURN(id.local_map, LocalMap(ref.slot()));
  if (!id.local_map.IsValid()) return Id();
  if (ref.index() == Id::kNoIndex) return OutOfRange("index", ref.index(), 0u, Id::kNoIndex - 1);
  id.index = ref.index();
  return id;
}

template <typename Id>
absl::StatusOr<std::vector<Id>> SlotReader::Column(const v1::ItemIds& ids, absl::string_view field,
                                                   bool may_be_none) const {
  const int count = ids.index_deltas_size();
  if (ids.slots_size() != 0 && ids.slots_size() != count) {
    return BadLength(absl::StrCat(field, ".slots"), ids.slots_size(), count);
  }
  std::vector<Id> column;
  column.reserve(static_cast<size_t>(count));
  int64_t index = 0;
  for (int i = 0; i < count; ++i) {
    const uint32_t slot = ids.slots_size() == 0 ? 1 : ids.slots(i);
    if (slot >= maps_.size() || (slot == 0 && !may_be_none)) {
      return OutOfRange(absl::StrCat(field, ".slots[", i, "]"), slot, size_t{may_be_none ? 0u : 1u},
                        maps_.size() - 1);
    }
    // The bound on the delta keeps the sum from overflowing.
    const int64_t delta = ids.index_deltas(i);
    const bool in_step = delta <= Id::kNoIndex && delta >= -int64_t{Id::kNoIndex};
    if (in_step) index += delta;
    if (!in_step || index < 0 || index >= Id::kNoIndex) {
      return OutOfRange(absl::StrCat(field, ": index of entry ", i), in_step ? index : delta,
                        int64_t{0}, int64_t{Id::kNoIndex} - 1);
    }
    if (slot == 0) {
      column.push_back(Id());
    } else {
      column.push_back({maps_[slot], static_cast<uint32_t>(index)});
    }
  }
  return column;
}

template absl::StatusOr<KeyframeId> SlotReader::Ref(const v1::ItemRef&) const;
template absl::StatusOr<MapPointId> SlotReader::Ref(const v1::ItemRef&) const;
template absl::StatusOr<std::vector<KeyframeId>> SlotReader::Column(const v1::ItemIds&,
                                                                    absl::string_view, bool) const;
template absl::StatusOr<std::vector<MapPointId>> SlotReader::Column(const v1::ItemIds&,
                                                                    absl::string_view, bool) const;

absl::Status CheckOwned(const std::vector<MapPointId>& ids, LocalMapId owner,
                        absl::string_view field) {
  return CheckAllOwned(ids, owner, field);
}

absl::Status CheckOwned(const std::vector<KeyframeId>& ids, LocalMapId owner,
                        absl::string_view field) {
  return CheckAllOwned(ids, owner, field);
}

}  // namespace corbslam::services
