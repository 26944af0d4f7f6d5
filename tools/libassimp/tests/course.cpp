// A typical program of a first course in animation. It loads a motion with the highest quality and without bones,
// and prints its content. Then it plays the motion: it writes each channel into its node, and prints the world position
// of every node.
//
//     course motion.bvh

#include <algorithm>
#include <iostream>

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

namespace {

void printMatrix(const aiMatrix4x4 &matrix)
{
    for (unsigned row = 0; row < 4; row++) {
        for (unsigned column = 0; column < 4; column++) {
            std::cout << ' ' << matrix[row][column];
        }
    }
    std::cout << '\n';
}

void printScene(const aiScene *scene)
{
    std::cout << "animations " << scene->mNumAnimations << ", cameras " << scene->mNumCameras << ", lights "
              << scene->mNumLights << ", materials " << scene->mNumMaterials << ", meshes " << scene->mNumMeshes
              << ", textures " << scene->mNumTextures << '\n';
    for (unsigned index = 0; index < scene->mNumMeshes; index++) {
        const aiMesh *mesh = scene->mMeshes[index];
        std::cout << "mesh " << index << ": vertices " << mesh->mNumVertices << ", faces " << mesh->mNumFaces
                  << ", bones " << mesh->mNumBones << ", material " << mesh->mMaterialIndex << '\n';
        aiColor4D colour;
        if (aiGetMaterialColor(scene->mMaterials[mesh->mMaterialIndex], AI_MATKEY_COLOR_DIFFUSE, &colour) == AI_SUCCESS) {
            std::cout << "colour " << colour.r << ' ' << colour.g << ' ' << colour.b << '\n';
        }
    }
}

void printTree(const aiNode *node)
{
    std::cout << "node " << node->mName.C_Str() << ", parent "
              << (node->mParent ? node->mParent->mName.C_Str() : "none") << ", children " << node->mNumChildren
              << ", meshes";
    for (unsigned index = 0; index < node->mNumMeshes; index++) {
        std::cout << ' ' << node->mMeshes[index];
    }
    std::cout << "\n ";
    printMatrix(node->mTransformation);
    for (unsigned child = 0; child < node->mNumChildren; child++) {
        printTree(node->mChildren[child]);
    }
}

void printAnimation(const aiAnimation *animation)
{
    std::cout << "animation " << animation->mName.C_Str() << ": channels " << animation->mNumChannels << ", duration "
              << animation->mDuration << " ticks, ticks per second " << animation->mTicksPerSecond << '\n';
    for (unsigned index = 0; index < animation->mNumChannels; index++) {
        const aiNodeAnim *channel = animation->mChannels[index];
        std::cout << "channel " << channel->mNodeName.C_Str() << ": positions " << channel->mNumPositionKeys
                  << ", rotations " << channel->mNumRotationKeys << ", scalings " << channel->mNumScalingKeys << '\n';
        for (unsigned key = 0; key < channel->mNumPositionKeys; key++) {
            const aiVectorKey &position = channel->mPositionKeys[key];
            std::cout << "  position " << position.mTime << ": " << position.mValue.x << ' ' << position.mValue.y
                      << ' ' << position.mValue.z << '\n';
        }
        for (unsigned key = 0; key < channel->mNumRotationKeys; key++) {
            const aiQuatKey &rotation = channel->mRotationKeys[key];
            std::cout << "  rotation " << rotation.mTime << ": " << rotation.mValue.w << ' ' << rotation.mValue.x
                      << ' ' << rotation.mValue.y << ' ' << rotation.mValue.z << '\n';
        }
    }
}

// A track that never changes has one key.
template <typename Key>
const Key &keyAt(const Key *keys, unsigned count, unsigned tick)
{
    return keys[std::min(tick, count - 1)];
}

void updateNodeMatrices(const aiScene *scene, const aiAnimation *animation, unsigned tick)
{
    for (unsigned index = 0; index < animation->mNumChannels; index++) {
        const aiNodeAnim *channel = animation->mChannels[index];
        const aiVector3D &position = keyAt(channel->mPositionKeys, channel->mNumPositionKeys, tick).mValue;
        const aiQuaternion &rotation = keyAt(channel->mRotationKeys, channel->mNumRotationKeys, tick).mValue;
        aiMatrix4x4 translation;
        aiMatrix4x4::Translation(position, translation);
        aiNode *node = scene->mRootNode->FindNode(channel->mNodeName);
        node->mTransformation = translation * aiMatrix4x4(rotation.GetMatrix());
    }
}

// Uses the functions of the C interface. The course passes matrices to OpenGL in column-major order.
void printWorld(const aiNode *node, const aiMatrix4x4 &parentToWorld)
{
    aiMatrix4x4 nodeToWorld = parentToWorld;
    aiMultiplyMatrix4(&nodeToWorld, &node->mTransformation);
    aiVector3D tip(0, 1, 0);
    aiTransformVecByMatrix4(&tip, &nodeToWorld);
    aiMatrix4x4 columns = nodeToWorld;
    aiTransposeMatrix4(&columns);
    std::cout << "  " << node->mName.C_Str() << ' ' << tip.x << ' ' << tip.y << ' ' << tip.z;
    printMatrix(columns);
    for (unsigned child = 0; child < node->mNumChildren; child++) {
        printWorld(node->mChildren[child], nodeToWorld);
    }
}

} // namespace

int main(int argc, char **argv)
{
    const aiScene *scene =
        argc == 2 ? aiImportFile(argv[1], aiProcessPreset_TargetRealtime_MaxQuality | aiProcess_Debone) : nullptr;
    if (!scene) {
        std::cout << "no scene: " << aiGetErrorString() << '\n';
        return 1;
    }
    printScene(scene);
    printTree(scene->mRootNode);
    for (unsigned index = 0; index < scene->mNumAnimations; index++) {
        const aiAnimation *animation = scene->mAnimations[index];
        printAnimation(animation);
        for (unsigned tick = 0; tick <= animation->mDuration; tick++) {
            updateNodeMatrices(scene, animation, tick);
            aiMatrix4x4 identity;
            aiIdentityMatrix4(&identity);
            std::cout << "tick " << tick << '\n';
            printWorld(scene->mRootNode, identity);
        }
    }
    aiReleaseImport(scene);
}
