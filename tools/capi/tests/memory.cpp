// Reads the lecture's file from memory, and prints the path of its end effector.
//
//     memory lecture_Test.bvh

#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <mocap.h>

namespace {

struct Close {
    void operator()(mocap_scene *scene) const { mocap_close(scene); }
};
using Scene = std::unique_ptr<mocap_scene, Close>;

Scene open(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
    Scene scene(mocap_open_memory(bytes.data(), bytes.size(), path.c_str()));
    if (!scene) {
        throw std::runtime_error(mocap_error_text());
    }
    return scene;
}

} // namespace

int main(int argc, char **argv)
try {
    const Scene scene = open(argc > 1 ? argv[1] : "");
    const auto end = mocap_find_node(scene.get(), "EndSite_Wrist");
    std::vector<float> matrices(16 * mocap_node_count(scene.get()));
    for (double tick = 0; tick <= mocap_duration(scene.get(), 0); tick += 1) {
        if (mocap_world_matrices(scene.get(), 0, tick, matrices.data(), matrices.size() / 16) != MOCAP_STATUS_OK) {
            throw std::runtime_error(mocap_error_text());
        }
        const float *position = &matrices[16 * end + 12];
        std::printf("%.0f %.3f %.3f %.3f\n", tick, position[0], position[1], position[2]);
    }
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
