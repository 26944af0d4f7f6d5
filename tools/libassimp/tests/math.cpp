// Calls every function of vectors, quaternions and matrices with the same random values, and prints the results.

#include <assimp/cimport.h>
#include <assimp/scene.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <tuple>
#include <type_traits>

namespace {

constexpr int CASES = 200;

/// SplitMix64.
struct Random {
    std::uint64_t state;

    float number() {
        state += 0x9e3779b97f4a7c15u;
        std::uint64_t mixed = (state ^ (state >> 30)) * 0xbf58476d1ce4e5b9u;
        mixed = (mixed ^ (mixed >> 27)) * 0x94d049bb133111ebu;
        return float(std::int64_t((mixed ^ (mixed >> 31)) >> 40)) / float(1 << 22) - 2.0f;
    }
};

/// The kind of values of a case.
enum Kind {
    ANY,
    WHOLE, // -1, 0 and 1: matrices without an inverse, vectors without a length
    ROTATIONS, // unit vectors and quaternions, matrices of rotation, scaling and translation
    EQUAL, // unit vectors and such matrices again, with all arguments equal
    NEARLY_EQUAL,
    KINDS,
};

/// The number of values that were made nearly equal, so that no two changes are equal.
int changes = 0;

template <class T> void fill(T &value, Random &random, Kind kind) {
    static_assert(sizeof(T) % sizeof(float) == 0, "it is made of floats");
    float *numbers = reinterpret_cast<float *>(&value);
    for (std::size_t index = 0; index < sizeof(T) / sizeof(float); ++index) {
        numbers[index] = kind == WHOLE ? std::round(random.number() * 0.74f) : random.number();
    }
    if (kind == ANY || kind == WHOLE) return;
    if constexpr (std::is_same_v<T, aiVector3D> || std::is_same_v<T, aiQuaternion>) value.Normalize();
    if constexpr (std::is_same_v<T, aiMatrix3x3> || std::is_same_v<T, aiMatrix4x4>) {
        aiQuaternion rotation(random.number(), random.number(), random.number(), random.number());
        rotation.Normalize();
        if constexpr (std::is_same_v<T, aiMatrix3x3>) {
            value = rotation.GetMatrix();
        } else {
            const aiVector3D place(random.number(), random.number(), random.number());
            aiMatrix4x4 scaling;
            aiMatrix4x4::Scaling(aiVector3D(random.number(), 1.0f, 2.0f), scaling);
            value = aiMatrix4x4(aiVector3D(1, 1, 1), rotation, place) * scaling;
        }
    }
    if (kind == NEARLY_EQUAL) numbers[0] += 1e-6f * float(++changes % 3);
}

void print(float number) {
    if (std::isnan(number)) {
        std::printf(" nan");
    } else {
        std::printf(" %.9g", number);
    }
}

void print(int number) { std::printf(" %d", number); }

template <class T> void print(const T &value) {
    const float *numbers = reinterpret_cast<const float *>(&value);
    for (std::size_t index = 0; index < sizeof(T) / sizeof(float); ++index) print(numbers[index]);
}

template <class T> using Value = std::remove_cv_t<std::remove_pointer_t<T>>;

template <class T> T argument(Value<T> &value) {
    if constexpr (std::is_pointer_v<T>) {
        return &value;
    } else {
        return value;
    }
}

template <class R, class... A> void probe(const char *name, R (*function)(A...)) {
    for (int index = 0; index < CASES; ++index) {
        const Kind kind = Kind(index % KINDS);
        Random random{std::uint64_t(index) * 1000003u};
        std::tuple<Value<A>...> values;
        std::apply(
            [&](auto &...value) {
                const auto next = [&](auto &it) {
                    if (kind == EQUAL || kind == NEARLY_EQUAL) random.state = std::uint64_t(index);
                    fill(it, random, kind);
                };
                (next(value), ...);
                std::printf("%s", name);
                if constexpr (std::is_void_v<R>) {
                    function(argument<A>(value)...);
                } else {
                    print(function(argument<A>(value)...));
                }
                (print(value), ...);
                std::printf("\n");
            },
            values);
    }
}

} // namespace

#define PROBE(function) probe(#function, function);

int main() {
    PROBE(aiVector2AreEqual)
    PROBE(aiVector2AreEqualEpsilon)
    PROBE(aiVector2Add)
    PROBE(aiVector2Subtract)
    PROBE(aiVector2Scale)
    PROBE(aiVector2SymMul)
    PROBE(aiVector2DivideByScalar)
    PROBE(aiVector2DivideByVector)
    PROBE(aiVector2Length)
    PROBE(aiVector2SquareLength)
    PROBE(aiVector2Negate)
    PROBE(aiVector2DotProduct)
    PROBE(aiVector2Normalize)
    PROBE(aiVector3AreEqual)
    PROBE(aiVector3AreEqualEpsilon)
    PROBE(aiVector3LessThan)
    PROBE(aiVector3Add)
    PROBE(aiVector3Subtract)
    PROBE(aiVector3Scale)
    PROBE(aiVector3SymMul)
    PROBE(aiVector3DivideByScalar)
    PROBE(aiVector3DivideByVector)
    PROBE(aiVector3Length)
    PROBE(aiVector3SquareLength)
    PROBE(aiVector3Negate)
    PROBE(aiVector3DotProduct)
    PROBE(aiVector3CrossProduct)
    PROBE(aiVector3Normalize)
    PROBE(aiVector3NormalizeSafe)
    PROBE(aiVector3RotateByQuaternion)
    PROBE(aiQuaternionFromEulerAngles)
    PROBE(aiQuaternionFromAxisAngle)
    PROBE(aiQuaternionFromNormalizedQuaternion)
    PROBE(aiQuaternionAreEqual)
    PROBE(aiQuaternionAreEqualEpsilon)
    PROBE(aiQuaternionNormalize)
    PROBE(aiQuaternionConjugate)
    PROBE(aiQuaternionMultiply)
    PROBE(aiQuaternionInterpolate)
    PROBE(aiCreateQuaternionFromMatrix)
    PROBE(aiMultiplyMatrix4)
    PROBE(aiMultiplyMatrix3)
    PROBE(aiTransposeMatrix4)
    PROBE(aiTransposeMatrix3)
    PROBE(aiTransformVecByMatrix4)
    PROBE(aiTransformVecByMatrix3)
    PROBE(aiMatrix3FromMatrix4)
    PROBE(aiMatrix3FromQuaternion)
    PROBE(aiMatrix3AreEqual)
    PROBE(aiMatrix3AreEqualEpsilon)
    PROBE(aiMatrix3Inverse)
    PROBE(aiMatrix3Determinant)
    PROBE(aiMatrix3RotationZ)
    PROBE(aiMatrix3FromRotationAroundAxis)
    PROBE(aiMatrix3Translation)
    PROBE(aiMatrix3FromTo)
    PROBE(aiMatrix4FromMatrix3)
    PROBE(aiMatrix4FromScalingQuaternionPosition)
    PROBE(aiMatrix4Add)
    PROBE(aiMatrix4AreEqual)
    PROBE(aiMatrix4AreEqualEpsilon)
    PROBE(aiMatrix4Inverse)
    PROBE(aiMatrix4Determinant)
    PROBE(aiMatrix4IsIdentity)
    PROBE(aiMatrix4FromEulerAngles)
    PROBE(aiMatrix4RotationX)
    PROBE(aiMatrix4RotationY)
    PROBE(aiMatrix4RotationZ)
    PROBE(aiMatrix4FromRotationAroundAxis)
    PROBE(aiMatrix4Translation)
    PROBE(aiMatrix4Scaling)
    PROBE(aiMatrix4FromTo)
    PROBE(aiIdentityMatrix4)
    PROBE(aiIdentityMatrix3)
    PROBE(aiDecomposeMatrix)
    PROBE(aiMatrix4DecomposeIntoScalingEulerAnglesPosition)
    PROBE(aiMatrix4DecomposeIntoScalingAxisAnglePosition)
    PROBE(aiMatrix4DecomposeNoScaling)
}
