// Compresses a clip with ACL, and decompresses it again: bytes, seconds, and the pose at every sample.
//
//     acl INPUT PRECISION OUTPUT
//
// INPUT: number of tracks and of samples (32-bit), samples a second (32-bit float), the parent of each track (32-bit, -1 for
// none), then for each sample and track rotation x y z w, translation x y z, scale x y z as 32-bit floats, in metres.
// OUTPUT has the samples in the same form. The line printed is JSON.

#include <acl/compression/compress.h>
#include <acl/compression/track_array.h>
#include <acl/core/ansi_allocator.h>
#include <acl/core/track_writer.h>
#include <acl/decompression/decompress.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

struct Transform {
  float rotation[4], translation[3], scale[3];
};

/// Receives a pose from the decoder, as an engine does.
struct Writer final : acl::track_writer {
  std::vector<Transform> pose;
  void RTM_SIMD_CALL write_rotation(uint32_t track, rtm::quatf_arg0 value) { rtm::quat_store(value, pose[track].rotation); }
  void RTM_SIMD_CALL write_translation(uint32_t track, rtm::vector4f_arg0 value) { rtm::vector_store3(value, pose[track].translation); }
  void RTM_SIMD_CALL write_scale(uint32_t track, rtm::vector4f_arg0 value) { rtm::vector_store3(value, pose[track].scale); }
};

std::vector<char> read(const char *path) {
  std::vector<char> bytes;
  std::FILE *file = std::fopen(path, "rb");
  if (!file) return bytes;
  char block[65536];
  for (size_t count; (count = std::fread(block, 1, sizeof block, file)) > 0;) bytes.insert(bytes.end(), block, block + count);
  std::fclose(file);
  return bytes;
}

uint32_t state = 1;
double next_random() {
  state = state * 1664525u + 1013904223u;
  return (state >> 8) / 16777216.0;
}

using Context = acl::decompression_context<acl::default_transform_decompression_settings>;

}  // namespace

int main(int count, char **arguments) {
  if (count != 4) return 2;
  const std::vector<char> bytes = read(arguments[1]);
  if (bytes.size() < 12) return 1;
  const float precision = static_cast<float>(std::atof(arguments[2]));
  uint32_t tracks, samples;
  float rate;
  std::memcpy(&tracks, &bytes[0], 4);
  std::memcpy(&samples, &bytes[4], 4);
  std::memcpy(&rate, &bytes[8], 4);
  const char *parents = bytes.data() + 12;
  const char *values = parents + 4 * tracks;
  if (bytes.size() != 12 + 4ull * tracks + 40ull * tracks * samples) return 1;

  acl::ansi_allocator allocator;
  acl::track_array_qvvf list(allocator, tracks);
  for (uint32_t track = 0; track < tracks; ++track) {
    acl::track_desc_transformf description;
    description.output_index = track;
    int32_t parent;
    std::memcpy(&parent, parents + 4 * track, 4);
    description.parent_index = parent < 0 ? acl::k_invalid_track_index : static_cast<uint32_t>(parent);
    description.precision = precision;
    description.shell_distance = 0.03f;
    acl::track_qvvf values_of = acl::track_qvvf::make_reserve(description, allocator, samples, rate);
    for (uint32_t sample = 0; sample < samples; ++sample) {
      Transform value;
      std::memcpy(&value, values + 40ull * (sample * static_cast<uint64_t>(tracks) + track), 40);
      values_of[sample] = rtm::qvv_set(rtm::quat_normalize(rtm::quat_load(value.rotation)), rtm::vector_load3(value.translation),
                                       rtm::vector_load3(value.scale));
    }
    list[track] = std::move(values_of);
  }

  acl::compression_settings settings = acl::get_default_compression_settings();
  acl::qvvf_transform_error_metric metric;
  settings.error_metric = &metric;
  acl::output_stats stats;
  acl::compressed_tracks *compressed = nullptr;
  const std::clock_t start = std::clock();
  const acl::error_result result = acl::compress_track_list(allocator, list, settings, compressed, stats);
  const double encode = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  if (result.any()) {
    std::fprintf(stderr, "%s\n", result.c_str());
    return 1;
  }

  Context context;
  context.initialize(*compressed);
  Writer writer;
  writer.pose.resize(tracks);
  std::FILE *output = std::fopen(arguments[3], "wb");
  if (!output) return 1;
  for (uint32_t sample = 0; sample < samples; ++sample) {
    context.seek(static_cast<float>(sample) / rate, acl::sample_rounding_policy::none);
    context.decompress_tracks(writer);
    std::fwrite(writer.pose.data(), sizeof(Transform), tracks, output);
  }
  std::fclose(output);

  // Poses of one clip in random order, and of 64 copies.
  const uint32_t copies = 64, poses = 100000;
  std::vector<void *> memory;
  std::vector<Context> contexts(copies);
  for (uint32_t copy = 0; copy < copies; ++copy) {
    memory.push_back(allocator.allocate(compressed->get_size(), 16));
    std::memcpy(memory.back(), compressed, compressed->get_size());
    contexts[copy].initialize(*acl::make_compressed_tracks(memory.back()));
  }
  const float duration = compressed->get_finite_duration();
  std::vector<std::pair<uint32_t, float>> places;
  for (uint32_t pose = 0; pose < poses; ++pose) {
    places.push_back({static_cast<uint32_t>(next_random() * copies), static_cast<float>(next_random() * duration)});
  }
  double least[2] = {1e9, 1e9};
  for (int round = 0; round < 5; ++round) {
    for (int cold = 0; cold < 2; ++cold) {
      const auto begin = Clock::now();
      for (const auto &place : places) {
        Context &of = cold ? contexts[place.first] : context;
        of.seek(place.second, acl::sample_rounding_policy::none);
        of.decompress_tracks(writer);
      }
      const double seconds = seconds_since(begin) / poses;
      if (seconds < least[cold]) least[cold] = seconds;
    }
  }
  std::printf("{\"bytes\": %u, \"encode\": %.6f, \"random\": %.4f, \"clips\": %.4f}\n", compressed->get_size(), encode, 1e6 * least[0],
              1e6 * least[1]);
  for (void *copy : memory) allocator.deallocate(copy, compressed->get_size());
  allocator.deallocate(compressed, compressed->get_size());
  return 0;
}
