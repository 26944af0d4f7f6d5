// Imports a format that only Assimp reads, and motion with steps that only Assimp has, in every way of the interface,
// and prints the scenes.
//
//     forward mesh.obj motion.bvh

#include <iostream>
#include <string>

#include <assimp/cexport.h>
#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/DefaultIOSystem.h>
#include <assimp/DefaultLogger.hpp>
#include <assimp/Exporter.hpp>
#include <assimp/Importer.hpp>
#include <assimp/LogStream.hpp>
#include <assimp/ProgressHandler.hpp>

namespace {

struct Files : Assimp::DefaultIOSystem {
    int &opened;
    explicit Files(int &opened) : opened(opened) {}
    Assimp::IOStream *Open(const char *path, const char *mode) override
    {
        opened++;
        return Assimp::DefaultIOSystem::Open(path, mode);
    }
};

struct Progress : Assimp::ProgressHandler {
    float &last;
    explicit Progress(float &last) : last(last) {}
    bool Update(float share) override
    {
        last = share;
        return true;
    }
};

struct Lines : Assimp::LogStream {
    int &count;
    explicit Lines(int &count) : count(count) {}
    void write(const char *) override { count++; }
};

void print(const char *how, const aiScene *scene)
{
    std::cout << "== " << how << '\n';
    if (!scene) {
        std::cout << "no scene\n";
        return;
    }
    std::cout << "nodes " << scene->mRootNode->mNumChildren << " meshes " << scene->mNumMeshes << " materials "
              << scene->mNumMaterials << " animations " << scene->mNumAnimations << '\n';
    for (unsigned index = 0; index < scene->mNumMeshes; index++) {
        const aiMesh *mesh = scene->mMeshes[index];
        std::cout << "mesh " << mesh->mNumVertices << ' ' << mesh->mNumFaces << " box " << mesh->mAABB.mMin.x << ' '
                  << mesh->mAABB.mMax.x << '\n';
        for (unsigned vertex = 0; vertex < mesh->mNumVertices; vertex++) {
            const aiVector3D &at = mesh->mVertices[vertex];
            // Adding 0 changes -0 to 0.
            std::cout << "  " << at.x + 0.0f << ' ' << at.y + 0.0f << ' ' << at.z + 0.0f << '\n';
        }
    }
}

} // namespace

int main(int argc, char **argv)
{
    const std::string mesh = argc > 1 ? argv[1] : "", motion = argc > 2 ? argv[2] : "";
    const unsigned other = aiProcess_MakeLeftHanded | aiProcess_FlipWindingOrder | aiProcess_GenBoundingBoxes;

    const aiScene *scene = aiImportFile(mesh.c_str(), aiProcess_Triangulate);
    print("a mesh, in C", scene);
    std::cout << (aiApplyPostProcessing(scene, other) == scene) << '\n';
    print("after steps", scene);
    aiReleaseImport(scene);

    scene = aiImportFile(motion.c_str(), other);
    print("a motion, with steps of Assimp's", scene);
    aiScene *copy = nullptr;
    aiCopyScene(scene, &copy);
    print("a copy", copy);
    aiFreeScene(copy);
    std::cout << "unknown format " << aiExportScene(scene, "none", "/nowhere", 0) << '\n';
    // Assimp prints nothing about these.
    std::cerr << aiGetErrorString() << '\n';
    aiReleaseImport(scene);
    scene = aiImportFile(motion.c_str(), 0);
    std::cout << (aiApplyPostProcessing(scene, other) == scene) << '\n';
    print("a motion, steps later", scene);
    aiReleaseImport(scene);

    int lines = 0, opened = 0;
    float last = 0;
    Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0);
    Assimp::DefaultLogger::get()->attachStream(new Lines(lines), Assimp::Logger::Info);
    Assimp::DefaultLogger::get()->info("a message");
    {
        Assimp::Importer importer;
        importer.SetIOHandler(new Files(opened));
        importer.SetProgressHandler(new Progress(last));
        print("a mesh, by handlers", importer.ReadFile(mesh, aiProcess_Triangulate));
        std::cout << (opened > 0) << " progress " << last << ' ' << importer.IsDefaultIOHandler() << '\n';
        opened = 0;
        print("a motion, by handlers", importer.ReadFile(motion, 0));
        std::cout << (opened > 0) << " progress " << last << '\n';
        aiScene *orphan = importer.GetOrphanedScene();
        Assimp::Exporter exporter;
        const aiExportDataBlob *blob = exporter.ExportToBlob(orphan, "stl");
        std::cout << "a blob " << (blob && blob->size > 0) << '\n';
        std::cout << "no such format " << exporter.Export(orphan, "none", "/nowhere") << '\n';
        delete orphan;
    }
    Assimp::DefaultLogger::kill();
    std::cout << "logged " << (lines > 1) << '\n';

    aiScene made;
    made.mRootNode = new aiNode("root");
    aiNode *child = new aiNode(std::string("a child with a long name"));
    made.mRootNode->addChildren(1, &child);
    std::cout << made.mRootNode->FindNode("a child with a long name")->mParent->mName.C_Str() << '\n';
    made.mMaterials = new aiMaterial *[made.mNumMaterials = 1] { new aiMaterial };
    aiString name("paint");
    for (int key = 0; key < 9; key++) {
        made.mMaterials[0]->AddProperty(&name, ("key" + std::to_string(key)).c_str());
    }
    made.mMaterials[0]->AddProperty(&name, AI_MATKEY_NAME);
    std::cout << made.mMaterials[0]->GetName().C_Str() << ' ' << made.mMaterials[0]->mNumProperties << '\n';
}
