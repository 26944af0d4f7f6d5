// Measures Assimp's times, with one line of JSON for each:
//
//     assimp-time FILE none|MaxQuality+Debone REPETITIONS
//
// import: aiImportFile of the whole file, from opening it to the finished scene. update: the node matrices of one tick
// as the course's programs compute them, on every tick of the animation: per channel translation times rotation, and
// the node looked up by its name.

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

using Clock = std::chrono::steady_clock;

static double microseconds_since(Clock::time_point start) {
    return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

// A track that never changes has one key.
template <typename Key>
static const Key &key_at(const Key *keys, unsigned count, unsigned tick) {
    return keys[std::min(tick, count - 1)];
}

static void update_node_matrices(const aiScene &scene, unsigned tick) {
    const aiAnimation &animation = *scene.mAnimations[0];
    for (unsigned i = 0; i < animation.mNumChannels; ++i) {
        const aiNodeAnim &channel = *animation.mChannels[i];
        const aiVector3D &position = key_at(channel.mPositionKeys, channel.mNumPositionKeys, tick).mValue;
        const aiQuaternion &rotation = key_at(channel.mRotationKeys, channel.mNumRotationKeys, tick).mValue;
        aiMatrix4x4 translation;
        aiMatrix4x4::Translation(position, translation);
        scene.mRootNode->FindNode(channel.mNodeName)->mTransformation = translation * aiMatrix4x4(rotation.GetMatrix());
    }
}

static void print(const char *what, std::vector<double> &times) {
    std::sort(times.begin(), times.end());
    std::printf("{\"what\":\"%s\",\"repetitions\":%zu,\"best_us\":%.3f,\"median_us\":%.3f}\n", what, times.size(),
                times.front(), times[times.size() / 2]);
}

int main(int count, char **arguments) {
    const std::string flags_name = count == 4 ? arguments[2] : "";
    const int repetitions = count == 4 ? std::atoi(arguments[3]) : 0;
    if (repetitions < 1 || (flags_name != "none" && flags_name != "MaxQuality+Debone")) {
        std::fprintf(stderr, "usage: assimp-time FILE none|MaxQuality+Debone REPETITIONS\n");
        return 2;
    }
    const unsigned flags =
        flags_name == "none" ? 0u : unsigned(aiProcessPreset_TargetRealtime_MaxQuality | aiProcess_Debone);

    std::vector<double> imports, updates;
    for (int i = 0; i < repetitions; ++i) {
        auto start = Clock::now();
        const aiScene *scene = aiImportFile(arguments[1], flags);
        imports.push_back(microseconds_since(start));
        if (scene == nullptr) {
            std::fprintf(stderr, "%s\n", aiGetErrorString());
            return 1;
        }
        const unsigned ticks = static_cast<unsigned>(scene->mAnimations[0]->mDuration) + 1;
        start = Clock::now();
        for (unsigned tick = 0; tick < ticks; ++tick) update_node_matrices(*scene, tick);
        updates.push_back(microseconds_since(start) / ticks);
        aiReleaseImport(scene);
    }
    print("import", imports);
    print("update", updates);
}
