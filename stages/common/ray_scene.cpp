#include "stages/common/ray_scene.hpp"

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include <stdexcept>

namespace meshmser {

struct RayScene::Handles {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  ~Handles() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }
};

namespace {

RTCRay make_ray(const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double nearest, double farthest) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(from.x());
  ray.org_y = static_cast<float>(from.y());
  ray.org_z = static_cast<float>(from.z());
  ray.dir_x = static_cast<float>(direction.x());
  ray.dir_y = static_cast<float>(direction.y());
  ray.dir_z = static_cast<float>(direction.z());
  ray.tnear = static_cast<float>(nearest);
  ray.tfar = static_cast<float>(farthest);
  ray.mask = 0xffffffffu;
  return ray;
}

}  // namespace

RayScene::RayScene(std::span<const Eigen::Vector3d> positions, std::span<const std::array<std::int32_t, 3>> triangles)
    : handles_(std::make_unique<Handles>()), centre_(Eigen::Vector3d::Zero()) {
  if (!positions.empty()) {
    Eigen::Vector3d low = positions.front(), high = positions.front();
    for (const Eigen::Vector3d& position : positions) {
      low = low.cwiseMin(position);
      high = high.cwiseMax(position);
    }
    centre_ = (low + high) / 2;
  }
  handles_->device = rtcNewDevice(nullptr);
  if (handles_->device == nullptr) throw std::runtime_error("Embree cannot start on this machine");
  handles_->scene = rtcNewScene(handles_->device);
  rtcSetSceneFlags(handles_->scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_COMPACT));
  RTCGeometry geometry = rtcNewGeometry(handles_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float), positions.size()));
  auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles.size()));
  if ((vertices == nullptr && !positions.empty()) || (indices == nullptr && !triangles.empty())) throw std::bad_alloc();
  for (std::size_t v = 0; v < positions.size(); ++v)
    for (int c = 0; c < 3; ++c)
      vertices[3 * v + static_cast<std::size_t>(c)] = static_cast<float>(positions[v][c] - centre_[c]);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) indices[3 * t + k] = static_cast<std::uint32_t>(triangles[t][k]);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(handles_->scene, geometry);
  rtcReleaseGeometry(geometry);
  // Built by one thread: the order of triangles in the hierarchy decides which of two is met on their common edge.
  tbb::task_arena one_thread(1);
  one_thread.execute([&] { rtcJoinCommitScene(handles_->scene); });
  if (rtcGetDeviceError(handles_->device) == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
}

RayScene::~RayScene() = default;

RayScene::Hit RayScene::intersect(const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double nearest,
                                  double farthest) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit hit{};
  hit.ray = make_ray(from - centre_, direction, nearest, farthest);
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(handles_->scene, &context, &hit);
  if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return {static_cast<std::int32_t>(hit.hit.primID), hit.ray.tfar, hit.hit.u, hit.hit.v};
}

bool RayScene::occluded(const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double nearest,
                        double farthest) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray = make_ray(from - centre_, direction, nearest, farthest);
  rtcOccluded1(handles_->scene, &context, &ray);
  return ray.tfar < 0;
}

}  // namespace meshmser
