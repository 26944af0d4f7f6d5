// Prints a scene as the helper functions of a computer graphics course have printed it over the years: printSceneInfo,
// printMeshInfo, printTreeInfo, printBoneInfo and printAnimInfo, in four layouts named for the year they first appear.
// Written from a description of those layouts. Numbers have six digits, the default of a C++ stream.

#pragma once

#include <assimp/material.h>
#include <assimp/scene.h>

#include <algorithm>
#include <ostream>
#include <string>

namespace course_text {

enum class Layout { y2017 = 2017, y2018 = 2018, y2019 = 2019, y2021 = 2021 };

class Printer {
public:
    Printer(std::ostream &out, Layout layout) : out(out), layout(layout) {}

    void print(const aiScene &scene) {
        scene_info(scene);
        if (recent()) mesh_info(scene);
        tree_info(*scene.mRootNode);
        if (layout == Layout::y2017) {
            weights_info(scene);
        } else {
            bone_info(scene);
        }
        anim_info(scene);
    }

private:
    std::ostream &out;
    Layout layout;

    bool recent() const { return layout >= Layout::y2019; }

    void heading(const std::string &title, char line, int before, int after) {
        out << std::string(before, line) << ' ' << title << ' ' << std::string(after, line) << '\n';
    }

    void matrix(const aiMatrix4x4 &m) {
        for (int row = 0; row < 4; ++row) {
            for (int column = 0; column < 4; ++column) out << m[row][column] << ' ';
        }
        out << '\n';
    }

    void mesh_line(const char *prefix, const aiScene &scene, unsigned index) {
        const aiMesh &mesh = *scene.mMeshes[index];
        out << prefix << index << ": nverts = " << mesh.mNumVertices << "  nfaces =  " << mesh.mNumFaces
            << "  nbones = " << mesh.mNumBones << "  Material index = " << mesh.mMaterialIndex << '\n';
    }

    void scene_info(const aiScene &scene) {
        if (recent()) {
            heading("Scene Data", '=', 23, 24);
        } else {
            out << "Success! \n";
            heading("Scene Data", '-', 16, 19);
        }
        out << "Number of animations = " << scene.mNumAnimations << '\n'
            << "Number of cameras = " << scene.mNumCameras << '\n'
            << "Number of lights = " << scene.mNumLights << '\n'
            << "Number of materials = " << scene.mNumMaterials << '\n'
            << "Number of meshes = " << scene.mNumMeshes << '\n'
            << "Number of textures = " << scene.mNumTextures << '\n';
        if (recent()) return;
        out << std::string(38, '-') << '\n';
        for (unsigned i = 0; i < scene.mNumMeshes; ++i) mesh_line("Mesh ", scene, i);
        if (layout != Layout::y2017) return;
        for (unsigned i = 0; i < scene.mNumMaterials; ++i) material(*scene.mMaterials[i], i);
    }

    // A colour that the material does not have prints as zeros.
    void colour(const char *label, const aiMaterial &material, const char *key) {
        aiColor4D colour(0, 0, 0, 0);
        material.Get(key, 0, 0, colour);
        out << label << colour.r << ' ' << colour.g << ' ' << colour.b << ' ' << colour.a;
    }

    void material(const aiMaterial &material, unsigned index) {
        float shininess = 0;
        material.Get(AI_MATKEY_SHININESS, shininess);
        out << "Material: " << index << '\n';
        colour("   Ambient = ", material, "$clr.ambient");
        colour("\n   Diffuse = ", material, "$clr.diffuse");
        colour("\n   Specular = ", material, "$clr.specular");
        out << "  Shininess = " << shininess << '\n';
    }

    void mesh_info(const aiScene &scene) {
        heading("Mesh Data", '=', 23, 29);
        out << "Number of meshes = " << scene.mNumMeshes << '\n';
        for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
            const aiMesh &mesh = *scene.mMeshes[i];
            mesh_line("Mesh index ", scene, i);
            aiColor4D colour;
            if (scene.mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_COLOR_DIFFUSE, colour) == aiReturn_SUCCESS) {
                out << "         Material colour: " << colour.r << "  " << colour.g << "  " << colour.b << '\n';
            }
            has("texture coordinates", mesh.HasTextureCoords(0));
            has("vertex colors", mesh.HasVertexColors(0));
            has("vertex normals", mesh.HasNormals());
        }
    }

    void has(const char *what, bool yes) { out << (yes ? "Mesh has " : "Mesh does not have ") << what << ".\n"; }

    void tree_info(const aiNode &node) {
        if (recent()) {
            heading("Node Data", '=', 20, 27);
        } else {
            heading("Node Data", '=', 13, 24);
        }
        out << "Node Name: " << node.mName.C_Str();
        if (layout != Layout::y2017) out << "  Parent: " << (node.mParent ? node.mParent->mName.C_Str() : "NO PARENT");
        out << "  nchild = " << node.mNumChildren << "  nmesh = " << node.mNumMeshes << '\n';
        if (node.mNumMeshes > 0 || layout == Layout::y2017) {
            out << "Mesh indices: ";
            for (unsigned i = 0; i < node.mNumMeshes; ++i) out << node.mMeshes[i] << ' ';
            out << '\n';
        }
        out << "Transformation:  ";
        matrix(node.mTransformation);
        for (unsigned i = 0; i < node.mNumChildren; ++i) tree_info(*node.mChildren[i]);
    }

    // The mesh section of 2017, the only layout that lists every weight.
    void weights_info(const aiScene &scene) {
        heading("Mesh Data", '-', 16, 19);
        for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
            const aiMesh &mesh = *scene.mMeshes[i];
            if (mesh.HasNormals()) out << "Mesh " << i << ": Has Normals.\n";
            if (mesh.HasVertexColors(0)) out << "Mesh " << i << ": Has Vertex Colors.\n";
            if (mesh.HasTextureCoords(0)) out << "Mesh " << i << ": Has Texture Coords.\n";
            if (!mesh.HasBones()) continue;
            out << "Mesh " << i << ": nbones = " << mesh.mNumBones << "  nverts = " << mesh.mNumVertices
                << "  nfaces = " << mesh.mNumFaces << '\n';
            for (unsigned k = 0; k < mesh.mNumBones; ++k) {
                const aiBone &bone = *mesh.mBones[k];
                out << " --- Bone Name: " << bone.mName.C_Str() << "  nweights = " << bone.mNumWeights << '\n'
                    << "     Offset matrix: ";
                matrix(bone.mOffsetMatrix);
                for (unsigned w = 0; w < bone.mNumWeights; ++w) {
                    out << "      Vertex id: " << bone.mWeights[w].mVertexId << "  weight = " << bone.mWeights[w].mWeight
                        << '\n';
                }
            }
        }
    }

    void bone_info(const aiScene &scene) {
        if (recent()) {
            heading("Bone Data", '=', 20, 27);
        } else {
            heading("Bone Data", '-', 16, 19);
        }
        for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
            const aiMesh &mesh = *scene.mMeshes[i];
            for (unsigned k = 0; k < mesh.mNumBones; ++k) {
                const aiBone &bone = *mesh.mBones[k];
                out << "Bone Name: " << bone.mName.C_Str() << "   Mesh: " << i << "  nweights = " << bone.mNumWeights
                    << "\n     Offset matrix: ";
                matrix(bone.mOffsetMatrix);
                if (bone.mNumWeights == 0) continue;
                const aiVertexWeight &first = bone.mWeights[0];
                const aiVertexWeight &last = bone.mWeights[bone.mNumWeights - 1];
                out << "      Vertex ids: " << first.mVertexId << "  " << last.mVertexId << '\n';
                if (layout < Layout::y2021) continue;
                out << "      Vertex weights: " << first.mWeight << "  " << last.mWeight << '\n';
            }
        }
    }

    void anim_info(const aiScene &scene) {
        if (recent()) {
            heading("Animation Data", '=', 20, 27);
        } else {
            heading("Animation Data", '-', 16, 19);
        }
        out << "Number of animations = " << scene.mNumAnimations << '\n';
        // From 2021 on the caller names one animation; a BVH file has one.
        const unsigned last = layout < Layout::y2021 ? scene.mNumAnimations : std::min(scene.mNumAnimations, 1u);
        for (unsigned i = 0; i < last; ++i) {
            const aiAnimation &animation = *scene.mAnimations[i];
            out << " --- Anim " << i << ":  Name = " << animation.mName.C_Str() << "  nchanls = " << animation.mNumChannels
                << (layout < Layout::y2021 ? " nticks = " : " nticks per sec = ") << animation.mTicksPerSecond
                << "  duration (ticks) = " << animation.mDuration << '\n';
            for (unsigned k = 0; k < animation.mNumChannels; ++k) channel(*animation.mChannels[k], k);
        }
    }

    // Scaling keys are only counted, never printed.
    void channel(const aiNodeAnim &channel, unsigned index) {
        out << "     Channel " << index << ": nodeName = " << channel.mNodeName.C_Str()
            << " nposkeys = " << channel.mNumPositionKeys << "  nrotKeys = " << channel.mNumRotationKeys
            << " nsclKeys = " << channel.mNumScalingKeys << '\n';
        for (unsigned i = 0; i < channel.mNumPositionKeys; ++i) {
            const aiVectorKey &key = channel.mPositionKeys[i];
            out << "        posKey " << i << ":  Time = " << key.mTime << " Value = " << key.mValue.x << ' '
                << key.mValue.y << ' ' << key.mValue.z << '\n';
        }
        for (unsigned i = 0; i < channel.mNumRotationKeys; ++i) {
            const aiQuatKey &key = channel.mRotationKeys[i];
            out << "        rotnKey " << i << ":  Time = " << key.mTime << " Value = " << key.mValue.w << ' '
                << key.mValue.x << ' ' << key.mValue.y << ' ' << key.mValue.z << '\n';
        }
    }
};

}  // namespace course_text
