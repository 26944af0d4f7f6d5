// Prints the world positions of a file's nodes, its unit and its up axis.

#include <assimp/cimport.h>
#include <assimp/scene.h>

#include <cstdio>
#include <cstring>

static void print(const aiNode *node, const aiMatrix4x4 &parent) {
    const aiMatrix4x4 world = parent * node->mTransformation;
    // Assimp splits a node of an FBX file into one for each part of its transform.
    if (!std::strstr(node->mName.C_Str(), "_$AssimpFbx$_")) {
        std::printf("%s: %.6g %.6g %.6g\n", node->mName.C_Str(), world.a4, world.b4, world.c4);
    }
    for (unsigned child = 0; child < node->mNumChildren; ++child) print(node->mChildren[child], world);
}

int main(int, char **arguments) {
    const aiScene *scene = aiImportFile(arguments[1], 0);
    if (!scene) {
        std::puts(aiGetErrorString());
        return 1;
    }
    float unit = 0;
    int up = -1, sign = 0;
    aiString format;
    scene->mMetaData->Get("UnitScaleFactor", unit);
    scene->mMetaData->Get("UpAxis", up);
    scene->mMetaData->Get("UpAxisSign", sign);
    scene->mMetaData->Get("SourceAsset_Format", format);
    std::printf("UnitScaleFactor: %.6g\nUpAxis: %d\nUpAxisSign: %d\nformat: %s\n", unit, up, sign, format.C_Str());
    print(scene->mRootNode, aiMatrix4x4());
    aiReleaseImport(scene);
}
