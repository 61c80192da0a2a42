#include "client_agent/ros2/ros2_discovery.h"

#include <ros2_humble_types.h>
#include <ros2_types.h>

#include <algorithm>
#include <cstring>

namespace corbslam::client_agent {
namespace {

template <typename Gid>
Gid MakeGid(const dds_guid_t& guid) {
  Gid gid = {};
  static_assert(sizeof(gid.data) >= sizeof(guid.v));
  std::memcpy(gid.data, guid.v, sizeof(guid.v));
  return gid;
}

template <typename Gid>
std::vector<Gid> MakeGids(const std::vector<dds_guid_t>& guids) {
  std::vector<Gid> gids;
  for (const dds_guid_t& guid : guids) gids.push_back(MakeGid<Gid>(guid));
  return gids;
}

template <typename Sequence, typename Element>
void Refer(Sequence& sequence, std::vector<Element>& elements) {
  sequence = {};
  sequence._length = sequence._maximum = static_cast<uint32_t>(elements.size());
  sequence._buffer = elements.data();
}

template <size_t size>
void CopyText(char (&to)[size], const std::string& from) {
  const size_t count = std::min(size - 1, from.size());
  std::memcpy(to, from.data(), count);
  to[count] = '\0';
}

template <typename Info, typename Node, typename Gid>
dds_return_t Write(dds_entity_t writer, const Ros2NodeInfo& info) {
  std::vector<Gid> readers = MakeGids<Gid>(info.readers);
  std::vector<Gid> writers = MakeGids<Gid>(info.writers);
  std::vector<Node> nodes(1);
  CopyText(nodes[0].node_namespace, info.node_namespace);
  CopyText(nodes[0].node_name, info.name);
  Refer(nodes[0].reader_gid_seq, readers);
  Refer(nodes[0].writer_gid_seq, writers);
  Info message = {};
  message.gid = MakeGid<Gid>(info.participant);
  Refer(message.node_entities_info_seq, nodes);
  return dds_write(writer, &message);
}

dds_topic_descriptor_t Renamed(const dds_topic_descriptor_t& type, const char* name) {
  return {type.m_size, type.m_align,          type.m_flagset,    type.m_nkeys,
          name,        type.m_keys,           type.m_nops,       type.m_ops,
          type.m_meta, type.type_information, type.type_mapping, type.restrict_data_representation};
}

}  // namespace

const dds_topic_descriptor_t& DiscoveryType(bool is_humble) {
  const dds_topic_descriptor_t& later = rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc;
  static const dds_topic_descriptor_t humble =
      Renamed(rmw_dds_common_humble_ParticipantEntitiesInfo_desc, later.m_typename);
  return is_humble ? humble : later;
}

dds_return_t WriteDiscovery(dds_entity_t writer, bool is_humble, const Ros2NodeInfo& info) {
  if (is_humble) {
    return Write<rmw_dds_common_humble_ParticipantEntitiesInfo,
                 rmw_dds_common_humble_NodeEntitiesInfo, rmw_dds_common_humble_Gid>(writer, info);
  }
  return Write<rmw_dds_common_msg_dds__ParticipantEntitiesInfo_,
               rmw_dds_common_msg_dds__NodeEntitiesInfo_, rmw_dds_common_msg_dds__Gid_>(writer,
                                                                                        info);
}

}  // namespace corbslam::client_agent
