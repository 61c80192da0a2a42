#include "slam/simulation/ray_caster.h"

#include <embree3/rtcore.h>

#include <cmath>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"
#include "slam/simulation/embree_handles.h"
#include "slam/simulation/scene_validation.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// A patch as shading reads it: one cache line.
struct alignas(64) PatchRecord {
  Eigen::Vector3f u_axis;
  Eigen::Vector3f v_axis;
  Eigen::Vector3f normal;
  float u_offset_m;
  float v_offset_m;
  float tone;
  uint32_t seed;
  Material material;
};

PatchRecord MakeRecord(const Patch& patch) {
  const Eigen::Vector3f across = patch.corners[2] - patch.corners[0];
  const Eigen::Vector3f other = patch.corners[3] - patch.corners[1];
  return {.u_axis = patch.u_axis,
          .v_axis = patch.v_axis,
          .normal = across.cross(other).normalized(),
          .u_offset_m = patch.u_offset_m,
          .v_offset_m = patch.v_offset_m,
          .tone = patch.tone,
          .seed = patch.seed,
          .material = patch.material};
}

// A mesh where it stands.
struct Placement {
  Eigen::Matrix3f rotation;
  Eigen::Vector3f translation;
  float inverse_scale;
  uint32_t seed;
  const std::vector<PatchRecord>* patches;
};

Placement MakePlacement(const Similarity3d& world_from_mesh, uint32_t seed,
                        const std::vector<PatchRecord>& patches) {
  return {.rotation = world_from_mesh.rotation.toRotationMatrix().cast<float>(),
          .translation = world_from_mesh.translation.cast<float>(),
          .inverse_scale = static_cast<float>(1 / world_from_mesh.scale),
          .seed = seed * 0x9E3779B1U,
          .patches = &patches};
}

struct BuiltMesh {
  EmbreeScene scene;
  std::vector<PatchRecord> patches;
};

BuiltMesh BuildMesh(RTCDevice device, const Mesh& mesh) {
  BuiltMesh built;
  built.patches.reserve(mesh.patches.size());
  built.scene = EmbreeScene(rtcNewScene(device));
  rtcSetSceneBuildQuality(built.scene.get(), RTC_BUILD_QUALITY_HIGH);
  rtcSetSceneFlags(built.scene.get(), RTC_SCENE_FLAG_ROBUST);
  const EmbreeGeometry geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD));
  const size_t count = mesh.patches.size();
  auto* corners = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 4 * count));
  auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
      geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 4 * sizeof(uint32_t), count));
  for (size_t i = 0; i < count; ++i) {
    const Patch& patch = mesh.patches[i];
    for (size_t k = 0; k < 4; ++k) {
      for (int axis = 0; axis < 3; ++axis) *corners++ = patch.corners[k][axis];
      *indices++ = static_cast<uint32_t>(4 * i + k);
    }
    built.patches.push_back(MakeRecord(patch));
  }
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometry(built.scene.get(), geometry.get());
  rtcCommitScene(built.scene.get());
  return built;
}

void AttachInstance(RTCDevice device, RTCScene top, RTCScene mesh, const Similarity3d& pose) {
  const EmbreeGeometry geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE));
  rtcSetGeometryInstancedScene(geometry.get(), mesh);
  Eigen::Matrix<float, 3, 4> transform;  // Column-major, as asked for below.
  transform.leftCols<3>() = (pose.scale * pose.rotation.toRotationMatrix()).cast<float>();
  transform.col(3) = pose.translation.cast<float>();
  rtcSetGeometryTransform(geometry.get(), 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform.data());
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometry(top, geometry.get());
}

uint32_t PatchKey(uint32_t instance, uint32_t patch) {
  return (((instance + 1) * 0x9E3779B1U) ^ ((patch + 1) * 0x85EBCA77U)) | 1U;
}

void Trace(RTCScene scene, const RayPacket& rays, RTCRayHit16& packet) {
  alignas(64) std::array<int, kLanes> valid;
  for (size_t i = 0; i < kLanes; ++i) valid[i] = rays.active[i] ? -1 : 0;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(valid.data(), scene, &context, &packet);
}

RTCRayHit16 MakeQuery(const RayPacket& rays) {
  RTCRayHit16 packet = {};
  for (size_t i = 0; i < kLanes; ++i) {
    packet.ray.org_x[i] = rays.origin.x();
    packet.ray.org_y[i] = rays.origin.y();
    packet.ray.org_z[i] = rays.origin.z();
    packet.ray.dir_x[i] = rays.direction_x[i];
    packet.ray.dir_y[i] = rays.direction_y[i];
    packet.ray.dir_z[i] = rays.direction_z[i];
    packet.ray.tnear[i] = 0.05F;
    packet.ray.tfar[i] = 2000.0F;
    packet.ray.mask[i] = ~0U;
    packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  return packet;
}

}  // namespace

// The scene of the movers at one time.
class MoverPoses {
 public:
  EmbreeScene scene;
  std::vector<Placement> placements;
};

namespace {

class EmbreeRayCaster final : public RayCaster {
 public:
  EmbreeRayCaster(Scene scene, EmbreeDevice device)
      : scene_(std::move(scene)), device_(std::move(device)) {
    for (const Mesh& mesh : scene_.meshes) meshes_.push_back(BuildMesh(device_.get(), mesh));
    top_ = EmbreeScene(rtcNewScene(device_.get()));
    rtcSetSceneBuildQuality(top_.get(), RTC_BUILD_QUALITY_HIGH);
    rtcSetSceneFlags(top_.get(), RTC_SCENE_FLAG_ROBUST);
    for (const Instance& instance : scene_.instances) {
      const BuiltMesh& mesh = meshes_[instance.mesh];
      AttachInstance(device_.get(), top_.get(), mesh.scene.get(), instance.world_from_mesh);
      placements_.push_back(MakePlacement(instance.world_from_mesh, instance.seed, mesh.patches));
    }
    rtcCommitScene(top_.get());
    for (Mesh& mesh : scene_.meshes) Mesh().patches.swap(mesh.patches);  // Embree has them now.
  }

  const Scene& scene() const override { return scene_; }

  std::shared_ptr<const MoverPoses> PlaceMovers(double time_s) const override {
    if (scene_.movers.empty()) return nullptr;
    auto poses = std::make_shared<MoverPoses>();
    poses->scene = EmbreeScene(rtcNewScene(device_.get()));
    rtcSetSceneBuildQuality(poses->scene.get(), RTC_BUILD_QUALITY_HIGH);
    rtcSetSceneFlags(poses->scene.get(), RTC_SCENE_FLAG_ROBUST);
    for (const Mover& mover : scene_.movers) {
      const BuiltMesh& mesh = meshes_[mover.mesh];
      const Similarity3d pose = Similarity3d::FromRigid(PoseAt(mover, time_s));
      AttachInstance(device_.get(), poses->scene.get(), mesh.scene.get(), pose);
      poses->placements.push_back(MakePlacement(pose, mover.seed, mesh.patches));
    }
    rtcCommitScene(poses->scene.get());
    return poses;
  }

  void Cast(const RayPacket& rays, const MoverPoses* movers, HitPacket& hits) const override {
    RTCRayHit16 packet = MakeQuery(rays);
    Trace(top_.get(), rays, packet);
    if (movers == nullptr) {
      for (size_t i = 0; i < kLanes; ++i) Describe(rays, packet, i, placements_, 0, hits);
      return;
    }
    // A second query that starts with the first one's distances finds what is nearer.
    RTCRayHit16 nearer = MakeQuery(rays);
    std::copy(std::begin(packet.ray.tfar), std::end(packet.ray.tfar), std::begin(nearer.ray.tfar));
    Trace(movers->scene.get(), rays, nearer);
    for (size_t i = 0; i < kLanes; ++i) {
      if (nearer.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID) {
        Describe(rays, nearer, i, movers->placements, 1U << 30, hits);
      } else {
        Describe(rays, packet, i, placements_, 0, hits);
      }
    }
  }

 private:
  // What lane `i` hit.
  void Describe(const RayPacket& rays, const RTCRayHit16& packet, size_t i,
                const std::vector<Placement>& placements, uint32_t first_key,
                HitPacket& hits) const {
    const bool hit = rays.active[i] && packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    hits.surface.hit[i] = hit;
    hits.depth_m[i] = hit ? packet.ray.tfar[i] : 0.0F;
    hits.patch[i] = 0;
    if (!hit) return;
    const uint32_t instance = packet.hit.instID[0][i];
    const Placement& at = placements[instance];
    const PatchRecord& patch = (*at.patches)[packet.hit.primID[i]];
    hits.patch[i] = PatchKey(instance + first_key, packet.hit.primID[i]);
    const Eigen::Vector3f direction(rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]);
    const Eigen::Vector3f x_in_world = rays.origin + packet.ray.tfar[i] * direction;
    FillPlace(rays, direction, x_in_world, packet.ray.tfar[i], at, patch, i, hits.surface);
    const Eigen::Vector3f normal = at.rotation * patch.normal;
    const Light& light = scene_.light;
    // Two-sided: the side that the eye sees is lit when the sun is on it too.
    const float facing = normal.dot(direction) > 0 ? -1.0F : 1.0F;
    float sun = facing * normal.dot(light.towards_sun);
    if (patch.material == Material::kLeaves) sun = 0.6F + 0.4F * sun;
    hits.light[i] = patch.tone * (light.ambient + (1 - light.ambient) * std::max(sun, 0.0F));
  }

  static void FillPlace(const RayPacket& rays, const Eigen::Vector3f& direction,
                        const Eigen::Vector3f& x_in_world, float depth_m, const Placement& at,
                        const PatchRecord& patch, size_t i, SurfacePacket& surface) {
    const Eigen::Vector3f x = (x_in_world - at.translation) * at.inverse_scale;
    const Eigen::Vector3f u_axis = at.rotation * patch.u_axis;
    const Eigen::Vector3f v_axis = at.rotation * patch.v_axis;
    const Eigen::Vector3f normal = at.rotation * patch.normal;
    surface.u_m[i] = u_axis.dot(x) + patch.u_offset_m;
    surface.v_m[i] = v_axis.dot(x) + patch.v_offset_m;
    // The ray of the next pixel meets the patch's plane at a displaced place.
    const float slope = normal.dot(direction);
    const float steep = std::abs(slope) > 1e-4F ? slope : 1e-4F;
    const float right = normal.dot(rays.pixel_right) / steep;
    const float down = normal.dot(rays.pixel_down) / steep;
    const float scale = depth_m * at.inverse_scale;
    const float du = u_axis.dot(direction);
    const float dv = v_axis.dot(direction);
    surface.pixel_u_m[i] = scale * (std::abs(u_axis.dot(rays.pixel_right) - du * right) +
                                    std::abs(u_axis.dot(rays.pixel_down) - du * down));
    surface.pixel_v_m[i] = scale * (std::abs(v_axis.dot(rays.pixel_right) - dv * right) +
                                    std::abs(v_axis.dot(rays.pixel_down) - dv * down));
    surface.seed[i] = patch.seed ^ at.seed;
    surface.material[i] = patch.material;
  }

  Scene scene_;
  EmbreeDevice device_;
  std::vector<BuiltMesh> meshes_;
  EmbreeScene top_;
  std::vector<Placement> placements_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<RayCaster>> RayCaster::Make(Scene scene) {
  RETURN_IF_ERROR(Validate(scene));
  EmbreeDevice device(rtcNewDevice(nullptr));
  if (device == nullptr) {
    return absl::InternalError(absl::StrFormat("the ray caster can't start: Embree error %d",
                                               static_cast<int>(rtcGetDeviceError(nullptr))));
  }
  return std::make_unique<EmbreeRayCaster>(std::move(scene), std::move(device));
}

}  // namespace corbslam
