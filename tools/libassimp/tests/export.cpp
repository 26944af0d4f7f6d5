// Imports a scene and prints its nodes and the length of its motion. If PLACE is given, writes the scene as glTF.
//
//     export motion.bvh [PLACE]     PLACE.glb, PLACE.gltf, PLACE.blob.glb, PLACE.blob.gltf

#include <fstream>
#include <iostream>
#include <string>

#include <assimp/cexport.h>
#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

namespace {

void print(const aiNode *node)
{
    std::cout << "node " << node->mName.C_Str() << '\n';
    for (unsigned child = 0; child < node->mNumChildren; child++) {
        print(node->mChildren[child]);
    }
}

bool write(const aiScene *scene, const std::string &place, const std::string &id, const std::string &extension)
{
    if (!place.empty() && aiExportScene(scene, id.c_str(), (place + extension).c_str(), 0) != AI_SUCCESS) {
        return false;
    }
    const aiExportDataBlob *blob = aiExportSceneToBlob(scene, id.c_str(), 0);
    if (!blob) {
        return false;
    }
    if (!place.empty()) {
        std::ofstream file(place + ".blob" + extension, std::ios::binary);
        file.write(static_cast<const char *>(blob->data), static_cast<std::streamsize>(blob->size));
    }
    aiReleaseExportBlob(blob);
    return true;
}

} // namespace

int main(int argc, char **argv)
{
    const std::string place = argc > 2 ? argv[2] : "";
    for (unsigned flags : {0u, unsigned(aiProcessPreset_TargetRealtime_MaxQuality | aiProcess_Debone)}) {
        const aiScene *scene = aiImportFile(argc > 1 ? argv[1] : "", flags);
        if (!scene) {
            std::cerr << aiGetErrorString() << '\n';
            return 1;
        }
        print(scene->mRootNode);
        if (scene->mNumAnimations > 0) {
            const aiAnimation *animation = scene->mAnimations[0];
            std::cout << "seconds " << animation->mDuration / animation->mTicksPerSecond << '\n';
        }
        const bool written = argc < 2 || (write(scene, place, "glb2", ".glb") && write(scene, place, "gltf2", ".gltf"));
        if (!written || aiExportSceneToBlob(scene, "none", 0) != nullptr) {
            std::cerr << aiGetErrorString() << '\n';
            return 1;
        }
        aiReleaseImport(scene);
    }
}
