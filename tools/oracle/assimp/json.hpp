// Writes a whole aiScene as JSON: every number with enough digits for the same bits (9 for a float, 17 for a double).
// JSON has no NaN and no infinities, so these are the strings "nan", "inf" and "-inf".

#pragma once

#include <assimp/scene.h>

#include <cmath>
#include <cstdio>
#include <ostream>
#include <string>
#include <string_view>

namespace json {

inline std::string number(double value, int digits) {
    if (std::isnan(value)) return "\"nan\"";
    if (std::isinf(value)) return value < 0 ? "\"-inf\"" : "\"inf\"";
    char text[40];
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    return text;
}

inline std::string real(float value) { return number(value, 9); }
inline std::string real(double value) { return number(value, 17); }

// Length of the valid UTF-8 sequence that begins `text`, 0 if it is none.
inline std::size_t utf8_length(std::string_view text) {
    const auto first = static_cast<unsigned char>(text[0]);
    const std::size_t length = first < 0x80 ? 1 : first >= 0xC2 && first < 0xE0 ? 2 : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4 : 0;
    if (length == 0 || length > text.size()) return 0;
    for (std::size_t i = 1; i < length; ++i) {
        if ((static_cast<unsigned char>(text[i]) & 0xC0) != 0x80) return 0;
    }
    return length;
}

// Invalid UTF-8 bytes are read as Latin-1, so that the JSON is valid for any names in the file.
inline std::string quoted(std::string_view text) {
    std::string out = "\"";
    while (!text.empty()) {
        const auto byte = static_cast<unsigned char>(text[0]);
        const std::size_t length = utf8_length(text);
        if (byte == '"' || byte == '\\') {
            out += {'\\', text[0]};
        } else if (byte < 0x20 || length == 0) {
            char escape[8];
            std::snprintf(escape, sizeof escape, "\\u%04x", byte);
            out += escape;
        } else {
            out += text.substr(0, length);
        }
        text.remove_prefix(length == 0 ? 1 : length);
    }
    return out + '"';
}

inline std::string quoted(const aiString &text) { return quoted(std::string_view(text.data, text.length)); }

// The items that `write(index)` writes, with `separator` between them.
template <typename Write>
std::string list(std::size_t count, Write write, const char *separator = ",") {
    std::string out;
    for (std::size_t i = 0; i < count; ++i) {
        if (i > 0) out += separator;
        out += write(i);
    }
    return out;
}

inline std::string reals(const aiVector3D &v) { return real(v.x) + "," + real(v.y) + "," + real(v.z); }

inline std::string reals(const aiQuaternion &q) {
    return real(q.w) + "," + real(q.x) + "," + real(q.y) + "," + real(q.z);
}

// Row by row, as Assimp stores it.
inline std::string matrix(const aiMatrix4x4 &m) {
    return "[" + list(16, [&](std::size_t i) { return real(m[i / 4][i % 4]); }) + "]";
}

inline std::string flag(bool value) { return value ? "1" : "0"; }

inline std::string nodes(const aiNode &node) {
    std::string out = "  {\"name\":" + quoted(node.mName);
    out += ",\"parent\":" + (node.mParent ? quoted(node.mParent->mName) : "null");
    out += ",\"nchild\":" + std::to_string(node.mNumChildren);
    out += ",\"matrix\":" + matrix(node.mTransformation);
    out += ",\"meshes\":[" + list(node.mNumMeshes, [&](std::size_t i) { return std::to_string(node.mMeshes[i]); }) + "]}";
    for (unsigned i = 0; i < node.mNumChildren; ++i) out += ",\n" + nodes(*node.mChildren[i]);
    return out;
}

inline std::string bone(const aiBone &bone) {
    const auto weight = [&](std::size_t i) {
        return "[" + std::to_string(bone.mWeights[i].mVertexId) + "," + real(bone.mWeights[i].mWeight) + "]";
    };
    return "   {\"name\":" + quoted(bone.mName) + ",\"offset\":" + matrix(bone.mOffsetMatrix) + ",\"weights\":["
         + list(bone.mNumWeights, weight) + "]}";
}

inline std::string mesh(const aiMesh &mesh, std::size_t index) {
    const auto vectors = [&](const aiVector3D *values) {
        return list(values ? mesh.mNumVertices : 0, [=](std::size_t i) { return "[" + reals(values[i]) + "]"; });
    };
    const auto face = [&](std::size_t i) {
        const aiFace &face = mesh.mFaces[i];
        return "[" + list(face.mNumIndices, [&](std::size_t k) { return std::to_string(face.mIndices[k]); }) + "]";
    };
    std::string out = "  {\"index\":" + std::to_string(index) + ",\"name\":" + quoted(mesh.mName);
    out += ",\"nverts\":" + std::to_string(mesh.mNumVertices) + ",\"nfaces\":" + std::to_string(mesh.mNumFaces);
    out += ",\"nbones\":" + std::to_string(mesh.mNumBones) + ",\"material\":" + std::to_string(mesh.mMaterialIndex);
    out += ",\"primitive_types\":" + std::to_string(mesh.mPrimitiveTypes);
    out += ",\"has_uv\":" + flag(mesh.HasTextureCoords(0)) + ",\"has_color\":" + flag(mesh.HasVertexColors(0));
    out += ",\"has_tangents\":" + flag(mesh.HasTangentsAndBitangents());
    out += ",\"vertices\":[" + vectors(mesh.mVertices) + "],\"normals\":[" + vectors(mesh.mNormals) + "]";
    out += ",\"faces\":[" + list(mesh.mNumFaces, face) + "]";
    const char *open = mesh.mNumBones > 0 ? "[\n" : "[";
    return out + ",\"bones\":" + open
         + list(mesh.mNumBones, [&](std::size_t i) { return bone(*mesh.mBones[i]); }, ",\n") + "]}";
}

// The value of a material property: text, numbers, or the length of a buffer whose meaning is not known.
inline std::string property_value(const aiMaterialProperty &property) {
    const std::size_t words = property.mDataLength / 4;
    switch (property.mType) {
        case aiPTI_String:
            // Stored as a 32-bit length and the bytes.
            return quoted(std::string_view(property.mData + 4, property.mDataLength - 5));
        case aiPTI_Float:
            return "[" + list(words, [&](std::size_t i) { return real(reinterpret_cast<float *>(property.mData)[i]); }) + "]";
        case aiPTI_Integer:
            return "[" + list(words, [&](std::size_t i) {
                       return std::to_string(reinterpret_cast<int *>(property.mData)[i]);
                   }) + "]";
        default: return "null";
    }
}

inline std::string material(const aiMaterial &material) {
    const auto property = [&](std::size_t i) {
        const aiMaterialProperty &p = *material.mProperties[i];
        return "{\"key\":" + quoted(p.mKey) + ",\"semantic\":" + std::to_string(p.mSemantic)
             + ",\"index\":" + std::to_string(p.mIndex) + ",\"type\":" + std::to_string(p.mType)
             + ",\"length\":" + std::to_string(p.mDataLength) + ",\"value\":" + property_value(p) + "}";
    };
    return "  {\"properties\":[" + list(material.mNumProperties, property) + "]}";
}

// Keys as [time, values...].
template <typename Key>
std::string keys(const Key *keys, std::size_t count) {
    return "[" + list(count, [=](std::size_t i) { return "[" + real(keys[i].mTime) + "," + reals(keys[i].mValue) + "]"; })
         + "]";
}

inline std::string channel(const aiNodeAnim &channel) {
    return "   {\"node\":" + quoted(channel.mNodeName) + ",\"pre\":" + std::to_string(channel.mPreState)
         + ",\"post\":" + std::to_string(channel.mPostState)
         + ",\"pos\":" + keys(channel.mPositionKeys, channel.mNumPositionKeys)
         + ",\"rot_wxyz\":" + keys(channel.mRotationKeys, channel.mNumRotationKeys)
         + ",\"scl\":" + keys(channel.mScalingKeys, channel.mNumScalingKeys) + "}";
}

inline std::string animation(const aiAnimation &animation) {
    return "  {\"name\":" + quoted(animation.mName) + ",\"ticks_per_second\":" + real(animation.mTicksPerSecond)
         + ",\"duration\":" + real(animation.mDuration) + ",\"channels\":[\n"
         + list(animation.mNumChannels, [&](std::size_t i) { return channel(*animation.mChannels[i]); }, ",\n") + "]}";
}

// Only the string entries; a BVH scene has no others.
inline std::string metadata(const aiMetadata *metadata) {
    std::string out;
    for (unsigned i = 0; metadata && i < metadata->mNumProperties; ++i) {
        if (metadata->mValues[i].mType != AI_AISTRING) continue;
        if (!out.empty()) out += ",";
        out += quoted(metadata->mKeys[i]) + ":" + quoted(*static_cast<aiString *>(metadata->mValues[i].mData));
    }
    return "{" + out + "}";
}

inline void print_scene(std::ostream &out, const aiScene &scene) {
    out << "{\"flags\":" << scene.mFlags << ",\"counts\":{\"animations\":" << scene.mNumAnimations
        << ",\"cameras\":" << scene.mNumCameras << ",\"lights\":" << scene.mNumLights
        << ",\"materials\":" << scene.mNumMaterials << ",\"meshes\":" << scene.mNumMeshes
        << ",\"textures\":" << scene.mNumTextures << "},\n"
        << "\"metadata\":" << metadata(scene.mMetaData) << ",\n"
        << "\"nodes\":[\n" << nodes(*scene.mRootNode) << "],\n"
        << "\"meshes\":[\n" << list(scene.mNumMeshes, [&](std::size_t i) { return mesh(*scene.mMeshes[i], i); }, ",\n")
        << "],\n"
        << "\"materials\":[\n"
        << list(scene.mNumMaterials, [&](std::size_t i) { return material(*scene.mMaterials[i]); }, ",\n") << "],\n"
        << "\"animations\":[\n"
        << list(scene.mNumAnimations, [&](std::size_t i) { return animation(*scene.mAnimations[i]); }, ",\n") << "]}\n";
}

// The output in place of a scene if Assimp refuses the file.
inline void print_error(std::ostream &out, const char *message) {
    out << "{\"error\":" << quoted(std::string_view(message)) << "}\n";
}

}  // namespace json
