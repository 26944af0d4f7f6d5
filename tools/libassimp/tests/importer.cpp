// Imports repeatedly with the class of the C++ interface, and prints the scenes.
//
//     importer motion.bvh

#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

namespace {

void print(const char *how, const Assimp::Importer &importer, const aiScene *scene)
{
    std::cout << how << ": " << (scene == importer.GetScene()) << ' ';
    if (scene) {
        std::cout << scene->mNumMeshes << " meshes, " << scene->mRootNode->mName.C_Str() << ", error \""
                  << importer.GetErrorString() << "\"\n";
    } else {
        std::cout << "no scene, error " << (*importer.GetErrorString() != '\0') << '\n';
    }
}

void readFromMemory(const std::string &path, unsigned flags)
{
    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    Assimp::Importer importer;
    print("memory", importer, importer.ReadFileFromMemory(bytes.data(), bytes.size(), flags, "bvh"));
    importer.FreeScene();
    print("freed", importer, nullptr);
}

void readWithProperties(const std::string &path)
{
    Assimp::Importer importer;
    importer.SetPropertyFloat(AI_CONFIG_PP_CT_MAX_SMOOTHING_ANGLE, 30.0f);
    std::cout << importer.SetPropertyInteger(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, 1)
              << importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true) << '\n';
    print("without meshes", importer, importer.ReadFile(path, 0));
}

} // namespace

int main(int argc, char **argv)
{
    const std::string path = argc == 2 ? argv[1] : "";
    const unsigned flags = aiProcessPreset_TargetRealtime_MaxQuality | aiProcess_Debone;
    readFromMemory(path, flags);
    readWithProperties(path);

    Assimp::Importer importer;
    std::string extensions;
    importer.GetExtensionList(extensions);
    std::cout << importer.ValidateFlags(flags) << importer.IsExtensionSupported(".bvh")
              << (extensions.find("*.bvh") != std::string::npos) << '\n';
    Assimp::Importer missing;
    print("missing", missing, missing.ReadFile("/no/such/file.bvh", 0));
    print("file", importer, importer.ReadFile(path, flags));
    // Assimp's importer fails on a second motion.
    print("again", importer, importer.ReadFile(path, flags));
}
