// Prints every field of a scene that the course's program omits, imported in four ways. Then calls the functions that
// the course's program does not call.
//
//     everything motion.bvh

#include <cmath>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/version.h>

namespace {

void print(const char *what, const aiVector3D &vector)
{
    std::cout << ' ' << what << ' ' << vector.x << ' ' << vector.y << ' ' << vector.z;
}

void print(const char *what, const aiQuaternion &quaternion)
{
    std::cout << ' ' << what << ' ' << quaternion.w << ' ' << quaternion.x << ' ' << quaternion.y << ' '
              << quaternion.z;
}

void printMetadata(const aiMetadata *metadata)
{
    for (unsigned index = 0; metadata && index < metadata->mNumProperties; index++) {
        aiString value;
        metadata->Get(index, value);
        std::cout << "metadata " << metadata->mKeys[index].C_Str() << " = " << value.C_Str() << '\n';
    }
}

void printMaterial(const aiMaterial *material)
{
    std::cout << "material: properties " << material->mNumProperties;
    for (unsigned index = 0; index < material->mNumProperties; index++) {
        const aiMaterialProperty *property = material->mProperties[index];
        std::cout << ' ' << property->mKey.C_Str() << ' ' << property->mSemantic << ' ' << property->mIndex << ' '
                  << property->mType << ' ' << property->mDataLength;
    }
    aiString text;
    int whole[3] = {7, 8, 9};
    unsigned count = 3;
    std::cout << "; name " << material->Get(AI_MATKEY_NAME, text) << ' ' << text.C_Str() << ' ' << text.length;
    std::cout << "; two-sided " << aiGetMaterialIntegerArray(material, AI_MATKEY_TWOSIDED, whole, &count) << ' '
              << whole[0] << ' ' << whole[1] << ' ' << count;
    float number = 5;
    std::cout << "; as a float " << aiGetMaterialFloatArray(material, AI_MATKEY_TWOSIDED, &number, nullptr) << ' '
              << number;
    std::cout << "; shininess " << aiGetMaterialFloatArray(material, AI_MATKEY_SHININESS, &number, nullptr) << ' '
              << number;
    aiColor4D colour(1, 2, 3, 4);
    std::cout << "; diffuse " << aiGetMaterialColor(material, AI_MATKEY_COLOR_DIFFUSE, &colour) << ' ' << colour.r;
    std::cout << "; textures " << material->GetTextureCount(aiTextureType_DIFFUSE) << ' '
              << aiGetMaterialTexture(material, aiTextureType_DIFFUSE, 0, &text) << '\n';
}

void printMesh(const aiMesh *mesh)
{
    std::cout << "mesh \"" << mesh->mName.C_Str() << "\" primitives " << mesh->mPrimitiveTypes << " coordinates "
              << mesh->HasTextureCoords(0) << mesh->HasVertexColors(0) << mesh->HasTangentsAndBitangents()
              << mesh->HasNormals() << " morphs " << mesh->mNumAnimMeshes << ' ' << mesh->mMethod;
    print("box", mesh->mAABB.mMin);
    print("", mesh->mAABB.mMax);
    std::cout << '\n';
    for (unsigned vertex = 0; vertex < mesh->mNumVertices; vertex++) {
        print(" vertex", mesh->mVertices[vertex]);
        // Assimp leaves some normals with a length of twice the face's area.
        print("normal", aiVector3D(mesh->mNormals[vertex]).NormalizeSafe());
        std::cout << '\n';
    }
    for (unsigned face = 0; face < mesh->mNumFaces; face++) {
        std::cout << "  face";
        for (unsigned index = 0; index < mesh->mFaces[face].mNumIndices; index++) {
            std::cout << ' ' << mesh->mFaces[face].mIndices[index];
        }
        std::cout << '\n';
    }
    for (unsigned index = 0; index < mesh->mNumBones; index++) {
        const aiBone *bone = mesh->mBones[index];
        std::cout << "  bone " << bone->mName.C_Str() << ' ' << (bone->mNode != nullptr)
                  << (bone->mArmature != nullptr);
        for (unsigned row = 0; row < 4; row++) {
            for (unsigned column = 0; column < 4; column++) {
                // Adding 0 changes -0 to 0.
                std::cout << ' ' << bone->mOffsetMatrix[row][column] + 0.0f;
            }
        }
        for (unsigned weight = 0; weight < bone->mNumWeights; weight++) {
            std::cout << ' ' << bone->mWeights[weight].mVertexId << ':' << bone->mWeights[weight].mWeight;
        }
        std::cout << '\n';
    }
}

void printScene(const char *how, const aiScene *scene)
{
    std::cout << "== " << how << '\n';
    if (!scene) {
        std::cout << "no scene: " << aiGetErrorString() << '\n';
        return;
    }
    std::cout << "flags " << scene->mFlags << " name \"" << scene->mName.C_Str() << "\" skeletons "
              << scene->mNumSkeletons << '\n';
    printMetadata(scene->mMetaData);
    for (unsigned index = 0; index < scene->mNumMaterials; index++) {
        printMaterial(scene->mMaterials[index]);
    }
    for (unsigned index = 0; index < scene->mNumMeshes; index++) {
        printMesh(scene->mMeshes[index]);
    }
    for (unsigned index = 0; index < scene->mNumAnimations; index++) {
        const aiAnimation *animation = scene->mAnimations[index];
        std::cout << "animation \"" << animation->mName.C_Str() << "\" meshes " << animation->mNumMeshChannels << ' '
                  << animation->mNumMorphMeshChannels << '\n';
        for (unsigned channel = 0; channel < animation->mNumChannels; channel++) {
            const aiNodeAnim *keys = animation->mChannels[channel];
            std::cout << "  " << keys->mNodeName.C_Str() << ' ' << keys->mPreState << ' ' << keys->mPostState << ' '
                      << keys->mNumPositionKeys << ' ' << keys->mNumRotationKeys;
            for (unsigned key = 0; key < keys->mNumScalingKeys; key++) {
                print("scaling", keys->mScalingKeys[key].mValue);
            }
            std::cout << '\n';
        }
    }
    aiReleaseImport(scene);
}

void printMathematics()
{
    const aiQuaternion turns[] = {
        aiQuaternion(aiVector3D(0, 0, 1), 0.5f),
        aiQuaternion(aiVector3D(1, 2, 3).Normalize(), 2.9f),
        aiQuaternion(aiVector3D(-3, 1, 2).Normalize(), 3.1f),
        aiQuaternion(aiVector3D(1, -4, 2).Normalize(), -2.7f),
        aiQuaternion(aiVector3D(0.1f, 0.2f, -4).Normalize(), 2.2f),
    };
    for (const aiQuaternion &turn : turns) {
        for (float mirror : {1.0f, -1.0f}) {
            const aiVector3D scaling(2, 3, mirror * 0.5f);
            aiMatrix4x4 matrix(turn.GetMatrix());
            aiMatrix4x4 factor;
            matrix = matrix * aiMatrix4x4::Scaling(scaling, factor);
            matrix.a4 = 4, matrix.b4 = 5, matrix.c4 = 6;
            if (mirror < 0) {
                // Includes a matrix that shears.
                matrix.a2 += 1;
            }
            aiVector3D scale, position;
            aiQuaternion rotation;
            aiDecomposeMatrix(&matrix, &scale, &rotation, &position);
            print("scale", scale);
            print("rotation", rotation);
            print("position", position);
            aiMatrix3x3 turned = turn.GetMatrix();
            aiCreateQuaternionFromMatrix(&rotation, &turned);
            print("again", rotation);
            aiMatrix3x3 product = turned;
            aiTransposeMatrix3(&product);
            aiMultiplyMatrix3(&product, &turned);
            aiVector3D vector(1, 2, 3);
            aiTransformVecByMatrix3(&vector, &turned);
            print("vector", vector);
            aiIdentityMatrix3(&turned);
            std::cout << " identity " << (product.Equal(turned, 1e-6f) ? "yes" : "no") << '\n';
        }
    }
}

} // namespace

int main(int argc, char **argv)
{
    const char *path = argc == 2 ? argv[1] : "";
    const unsigned highest = aiProcessPreset_TargetRealtime_MaxQuality;
    printScene("as imported", aiImportFile(path, 0));
    printScene("fast", aiImportFile(path, aiProcessPreset_TargetRealtime_Fast));
    printScene("highest quality", aiImportFileEx(path, highest, nullptr));

    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    const auto size = static_cast<unsigned>(bytes.size());
    printScene("from memory, without bones",
               aiImportFileFromMemory(bytes.data(), size, highest | aiProcess_Debone, "bvh"));

    aiPropertyStore *store = aiCreatePropertyStore();
    aiString text("nothing");
    aiMatrix4x4 matrix;
    aiSetImportPropertyInteger(store, AI_CONFIG_IMPORT_NO_SKELETON_MESHES, 1);
    aiSetImportPropertyFloat(store, AI_CONFIG_PP_CT_MAX_SMOOTHING_ANGLE, 30.0f);
    aiSetImportPropertyString(store, AI_CONFIG_IMPORT_MDL_COLORMAP, &text);
    aiSetImportPropertyMatrix(store, AI_CONFIG_PP_PTV_ROOT_TRANSFORMATION, &matrix);
    printScene("without meshes", aiImportFileExWithProperties(path, 0, nullptr, store));
    aiReleasePropertyStore(store);

    printMathematics();
    std::cout << aiGetVersionMajor() << '.' << aiGetVersionMinor() << '.' << aiGetVersionPatch() << ' '
              << aiIsExtensionSupported(".bvh") << aiIsExtensionSupported("bvh") << aiIsExtensionSupported(".none")
              << '\n';
    aiString extensions;
    aiGetExtensionList(&extensions);
    std::cout << (std::strstr(extensions.C_Str(), "*.bvh") != nullptr) << '\n';

    aiLogStream stream = aiGetPredefinedLogStream(aiDefaultLogStream_STDERR, nullptr);
    aiAttachLogStream(&stream);
    aiDetachAllLogStreams();

    const aiScene *nothing = aiImportFile("/no/such/file.bvh", 0);
    std::cout << (nothing == nullptr) << (std::strstr(aiGetErrorString(), "/no/such/file.bvh") != nullptr);
    nothing = aiImportFileFromMemory("no motion", 9, 0, "bvh");
    std::cout << (nothing == nullptr) << (std::strlen(aiGetErrorString()) > 0) << '\n';
    aiReleaseImport(nullptr);
}
