#include "Widgets/PlanePose.h"

#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include <QtTest>

#include <random>

using namespace innergs;
using namespace innergs::ui;

namespace {

vtkSmartPointer<vtkMatrix4x4> matrixOf(const PlanePose& pose) {
  auto matrix = vtkSmartPointer<vtkMatrix4x4>::New();
  toMatrix(pose, matrix);
  return matrix;
}

double apart(vtkMatrix4x4* a, vtkMatrix4x4* b) {
  double most = 0;
  for (int i = 0; i < 16; ++i)
    most = std::max(most, std::abs(a->GetElement(i / 4, i % 4) - b->GetElement(i / 4, i % 4)));
  return most;
}

double apart(const Vec3& a, const Vec3& b) {
  return norm(a - b);
}

} // namespace

class PlanePoseTest : public QObject {
  Q_OBJECT
private Q_SLOTS:
  void orientationsAreThoseOfSliceViews() {
    // What vtkMRMLSliceNode::GetAxialSliceToRASMatrix etc. say: columns right, up, normal.
    struct Case {
      PlaneOrientation orientation;
      const char *right, *up, *normal;
    };
    for (const Case& c :
         {Case{PlaneOrientation::Axial, "L", "A", "S"}, Case{PlaneOrientation::Coronal, "L", "S", "A"},
          Case{PlaneOrientation::Sagittal, "P", "S", "L"}}) {
      PlanePose pose;
      pose.orientation = c.orientation;
      QCOMPARE(directionLetters(column(pose.axes(), 0)), QString(c.right));
      QCOMPARE(directionLetters(column(pose.axes(), 1)), QString(c.up));
      QCOMPARE(directionLetters(pose.normal()), QString(c.normal));
      const auto back = poseOf(matrixOf(pose));
      QVERIFY(back);
      QVERIFY(*back == pose);
    }
  }

  void anglesTurnAboutTheViewsAxes() {
    PlanePose pose; // axial: right is L, up is A, normal is S
    pose.angles.aboutHorizontal = 90;
    QCOMPARE(directionLetters(column(pose.axes(), 0)), QString("L"));
    QCOMPARE(directionLetters(column(pose.axes(), 1)), QString("S"));
    QCOMPARE(directionLetters(pose.normal()), QString("P"));
    pose.angles = {0, 90, 0};
    QCOMPARE(directionLetters(column(pose.axes(), 0)), QString("I"));
    QCOMPARE(directionLetters(column(pose.axes(), 1)), QString("A"));
    pose.angles = {0, 0, 90};
    QCOMPARE(directionLetters(column(pose.axes(), 0)), QString("A"));
    QCOMPARE(directionLetters(column(pose.axes(), 1)), QString("R"));
    QCOMPARE(directionLetters(pose.normal()), QString("S"));
  }

  void inPlaneAngleLeavesThePlaneAlone() {
    PlanePose pose;
    pose.orientation = PlaneOrientation::Sagittal;
    pose.angles = {20, -35, 0};
    const Vec3 normal = pose.normal();
    pose.angles.inPlane = 77;
    QVERIFY(apart(pose.normal(), normal) < 1e-12);
  }

  void matrixAndAnglesGoBothWays() {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> angle(-180, 180), place(-100, 100);
    for (int i = 0; i < 500; ++i) {
      PlanePose pose;
      pose.orientation = static_cast<PlaneOrientation>(i % 3);
      pose.reversed = i % 2;
      pose.angles = {angle(random), angle(random), angle(random)};
      pose.origin = {place(random), place(random), place(random)};
      const auto matrix = matrixOf(pose);
      const auto back = poseOf(matrix);
      QVERIFY(back);
      QVERIFY(apart(matrixOf(*back), matrix) < 1e-9);
      QVERIFY(std::abs(back->position() - pose.position()) < 1e-9);
    }
  }

  void rightAngleOfTheMiddleTiltIsNoTrap() {
    PlanePose pose;
    pose.angles = {30, 90, 40};
    const auto matrix = matrixOf(pose);
    QVERIFY(apart(matrixOf(poseOf(matrix).value()), matrix) < 1e-9);
    pose.turn(2, 0);
    QVERIFY(apart(matrixOf(pose), matrix) < 1e-9);
    QCOMPARE(pose.angles.inPlane, 40.);
    QVERIFY(std::abs(pose.angles.aboutHorizontal - 30) < 1e-6);
  }

  void turningGoesOnWithoutJumpsOfTheAngles() {
    for (int axis = 0; axis < 3; ++axis) {
      PlanePose pose;
      pose.angles = {5, 10, 20};
      pose.origin = {1, 2, 3};
      const Mat3 first = pose.axes();
      for (int step = 0; step < 360; ++step) {
        const PlaneAngles last = pose.angles;
        const Vec3 held = column(pose.axes(), axis);
        pose.turn(axis, 1);
        QVERIFY(apart(column(pose.axes(), axis), held) < 1e-9); // about its own axis
        const double jump = std::abs(std::remainder(pose.angles.aboutVertical - last.aboutVertical, 360));
        QVERIFY2(jump < 1.0001, qPrintable(QString("axis %1 at %2: %3").arg(axis).arg(step).arg(jump)));
      }
      QCOMPARE(pose.origin, (Vec3{1, 2, 3}));
      for (int c = 0; c < 3; ++c)
        QVERIFY(apart(column(pose.axes(), c), column(first, c)) < 1e-9);
    }
  }

  void positionIsTheOffsetAlongTheNormal() {
    PlanePose pose;
    pose.orientation = PlaneOrientation::Sagittal; // normal to the left
    pose.origin = {-12, 5, 7};
    QVERIFY(std::abs(pose.position() - 12) < 1e-12);
    pose.setPosition(20);
    QVERIFY(apart(pose.origin, {-20, 5, 7}) < 1e-12);
    pose.move(3, 4, -1); // to the back, up, to the right
    QVERIFY(apart(pose.origin, {-19, 2, 11}) < 1e-12);
    QVERIFY(apart(pose.toRAS(1, 2), {-19, 1, 13}) < 1e-12);
  }

  void scaledAndLeftHandedMatrices() {
    vtkNew<vtkMatrix4x4> matrix; // identity: right is R, up is A, normal is S
    auto pose = poseOf(matrix);
    QVERIFY(pose);
    QCOMPARE(directionLetters(column(pose->axes(), 0)), QString("R"));
    QCOMPARE(directionLetters(column(pose->axes(), 1)), QString("A"));
    QCOMPARE(directionLetters(pose->normal()), QString("S"));
    matrix->SetElement(0, 0, -0.5); // left-handed, pixels of half a millimetre
    matrix->SetElement(1, 1, 0.5);
    matrix->SetElement(2, 2, -3);
    matrix->SetElement(0, 3, 9);
    pose = poseOf(matrix);
    QVERIFY(pose);
    QCOMPARE(directionLetters(column(pose->axes(), 0)), QString("L"));
    QCOMPARE(directionLetters(column(pose->axes(), 1)), QString("A"));
    QCOMPARE(directionLetters(pose->normal()), QString("I"));
    QCOMPARE(pose->origin, (Vec3{9, 0, 0}));
    QVERIFY(pose->angles == PlaneAngles());
  }

  void noPlaneNoPose() {
    vtkNew<vtkMatrix4x4> matrix;
    QVERIFY(!poseOf(nullptr));
    matrix->SetElement(0, 0, 0);
    QVERIFY(!poseOf(matrix));
    matrix->Identity();
    matrix->SetElement(1, 3, std::nan(""));
    QVERIFY(!poseOf(matrix));
    matrix->Identity();
    matrix->SetElement(0, 1, 1); // up is the same as right
    matrix->SetElement(1, 1, 0);
    QVERIFY(!poseOf(matrix));
  }

  void extentHoldsTheBox() {
    PlanePose pose;
    pose.orientation = PlaneOrientation::Coronal; // L, S, A
    pose.origin = {10, 20, 30};
    const auto extent = extentOf(pose, {0, 20, -5, 45, 30, 40});
    const std::array<double, 6> expected{-10, 10, 0, 10, -25, 25};
    for (int i = 0; i < 6; ++i)
      QVERIFY(std::abs(extent[i] - expected[i]) < 1e-12);
    pose.angles = {0, 0, 45};
    const auto wide = extentOf(pose, {0, 20, 0, 0, 30, 50});
    QVERIFY(std::abs(wide[1] - wide[0] - 20 * std::sqrt(2)) < 1e-9);
  }

  void lettersOfObliqueDirections() {
    QCOMPARE(directionLetters({0.1, -1, 0}), QString("P"));
    QCOMPARE(directionLetters({0.5, -1, 0}), QString("PR"));
    QCOMPARE(directionLetters({-1, -1, 2}), QString("SLP"));
    QCOMPARE(positionText({-12.34, 5, -0.26}), QString("L 12.3, A 5.0, I 0.3"));
  }
};

QTEST_GUILESS_MAIN(PlanePoseTest)
#include "PlanePoseTest.moc"
