// Converts keyframe and map point ids to and from the compact form of the wire: a table of local
// maps, and slots in it.
#ifndef CORBSLAM_SERVICES_CONVERT_IDS_H_
#define CORBSLAM_SERVICES_CONVERT_IDS_H_

#include <cstdint>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "corbslam/v1/items.pb.h"
#include "slam/util/ids.h"

namespace corbslam::services {

using MapTable = google::protobuf::RepeatedField<uint64_t>;

// Fills the table of a message that is being written. `table` must outlive it.
class SlotWriter {
 public:
  // `own` is the local map that the message belongs to: slot 1, without an entry in the table;
  // invalid: none.
  explicit SlotWriter(MapTable* table, LocalMapId own = {});

  // Returns the local map's slot; 0 for an invalid id.
  uint32_t Slot(LocalMapId local_map);

  template <typename Id>
  void Write(Id id, v1::ItemRef* proto) {
    proto->set_slot(Slot(id.local_map));
    if (id.IsValid()) proto->set_index(id.index);
  }

 private:
  MapTable* table_;
  uint32_t next_ = 1;
  absl::flat_hash_map<LocalMapId, uint32_t> slots_;
};

// Appends to a column of ids, which nobody else may have begun.
class IdColumnWriter {
 public:
  IdColumnWriter(SlotWriter& slots, v1::ItemIds* column) : slots_(slots), column_(column) {}

  template <typename Id>
  void Add(Id id) {
    if (!id.IsValid()) return AddIndex(0, last_);
    AddIndex(slots_.Slot(id.local_map), id.index);
  }

 private:
  void AddIndex(uint32_t slot, int64_t index);

  SlotWriter& slots_;
  v1::ItemIds* column_;
  int64_t last_ = 0;
};

// Reads ids of one message. All errors are INVALID_ARGUMENT and name the field.
class SlotReader {
 public:
  static absl::StatusOr<SlotReader> Create(const MapTable& table, LocalMapId own = {});

  absl::StatusOr<LocalMapId> LocalMap(uint32_t slot) const;
  absl::StatusOr<KeyframeId> Keyframe(const v1::ItemRef& ref) const { return Ref<KeyframeId>(ref); }
  absl::StatusOr<MapPointId> Point(const v1::ItemRef& ref) const { return Ref<MapPointId>(ref); }
  // Reads a column of ids. Slot 0 is an error, unless `may_be_none`.
  absl::StatusOr<std::vector<KeyframeId>> Keyframes(const v1::ItemIds& ids, absl::string_view field,
                                                    bool may_be_none = false) const {
    return Column<KeyframeId>(ids, field, may_be_none);
  }
  absl::StatusOr<std::vector<MapPointId>> Points(const v1::ItemIds& ids, absl::string_view field,
                                                 bool may_be_none = false) const {
    return Column<MapPointId>(ids, field, may_be_none);
  }

 private:
  template <typename Id>
  absl::StatusOr<Id> Ref(const v1::ItemRef& ref) const;
  template <typename Id>
  absl::StatusOr<std::vector<Id>> Column(const v1::ItemIds& ids, absl::string_view field,
                                         bool may_be_none) const;

  std::vector<LocalMapId> maps_;  // Local maps by slot; the first is invalid.
};

// Returns PERMISSION_DENIED, naming the id, where an id is not of `owner`.
absl::Status CheckOwned(const std::vector<MapPointId>& ids, LocalMapId owner,
                        absl::string_view field);
absl::Status CheckOwned(const std::vector<KeyframeId>& ids, LocalMapId owner,
                        absl::string_view field);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_IDS_H_
