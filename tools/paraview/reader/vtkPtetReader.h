// A VTK reader of .ptet files: the mesh as coarse as error bounds and a budget allow, the original inside a focus
// region, and what its errors are.
//
//   properties --> ptet::Request --> ptet::Session --> vtkUnstructuredGrid
//                                                        point data   the arrays that are selected
//                                                        field data   "error of NAME", "domain error", ...
//
// The file stays open and its mesh in memory, so that a request that differs little from the last costs little. Asked
// for pieces it gives all of the mesh as the first. It needs VTK and the installed run-time library alone; the plugin
// beside it shows its properties in ParaView.
#ifndef vtkPtetReader_h
#define vtkPtetReader_h

#include <memory>

#include <vtkUnstructuredGridAlgorithm.h>

// NOLINTBEGIN(readability-identifier-naming): VTK's way
class vtkPtetReader : public vtkUnstructuredGridAlgorithm {
public:
  static vtkPtetReader* New();
  vtkTypeMacro(vtkPtetReader, vtkUnstructuredGridAlgorithm) void PrintSelf(ostream& os, vtkIndent indent) override;

  /// The .ptet file.
  vtkSetFilePathMacro(FileName);
  vtkGetFilePathMacro(FileName);
  /// 1 if the file begins as a .ptet file does.
  int CanReadFile(const char* name);

  /// The point arrays of the file, known once UpdateInformation() was called, and whether the output gets them; at
  /// first it gets all. The mesh is the same with or without them.
  int GetNumberOfPointArrays();
  const char* GetPointArrayName(int index);
  int GetPointArrayStatus(const char* name);
  void SetPointArrayStatus(const char* name, int status);

  /// A bound on the error of every governing field, in percent of its range, where BoundFieldErrors is on.
  vtkSetMacro(BoundFieldErrors, bool);
  vtkGetMacro(BoundFieldErrors, bool);
  vtkBooleanMacro(BoundFieldErrors, bool);
  vtkSetMacro(FieldError, double);
  vtkGetMacro(FieldError, double);
  /// Bounds on single fields, in percent of their ranges, whether or not BoundFieldErrors is on; they go before
  /// FieldError.
  void SetFieldErrorBound(const char* name, double percent);
  void ClearFieldErrorBounds();

  /// A bound on the distance between the boundary and the original one, in percent of the bounding box's diagonal.
  vtkSetMacro(BoundDomainError, bool);
  vtkGetMacro(BoundDomainError, bool);
  vtkBooleanMacro(BoundDomainError, bool);
  vtkSetMacro(DomainError, double);
  vtkGetMacro(DomainError, double);

  /// At most so many tetrahedra, the focus excepted: with no bound on errors, what keeps them small.
  vtkSetMacro(LimitTets, bool);
  vtkGetMacro(LimitTets, bool);
  vtkBooleanMacro(LimitTets, bool);
  vtkSetClampMacro(MaximumTets, vtkIdType, 0, VTK_ID_MAX);
  vtkGetMacro(MaximumTets, vtkIdType);

  enum FocusShapes { NO_FOCUS = 0, BOX = 1, SPHERE = 2 };
  /// The region with more detail than elsewhere.
  vtkSetClampMacro(FocusShape, int, NO_FOCUS, SPHERE);
  vtkGetMacro(FocusShape, int);
  /// The box as ParaView's box widget has it: the unit cube [0, 1]^3 scaled by BoxLength, turned by BoxRotation
  /// (degrees about y, then x, then z) and moved by BoxPosition.
  vtkSetVector3Macro(BoxPosition, double);
  vtkGetVector3Macro(BoxPosition, double);
  vtkSetVector3Macro(BoxRotation, double);
  vtkGetVector3Macro(BoxRotation, double);
  vtkSetVector3Macro(BoxLength, double);
  vtkGetVector3Macro(BoxLength, double);
  vtkSetVector3Macro(SphereCenter, double);
  vtkGetVector3Macro(SphereCenter, double);
  vtkSetMacro(SphereRadius, double);
  vtkGetMacro(SphereRadius, double);
  /// Largest error inside, of every governing field and the domain, in percent of ranges and diagonal; 0: the original.
  vtkSetMacro(FocusError, double);
  vtkGetMacro(FocusError, double);
  /// Outside, where UseFalloff is on, the error allowed grows by so many percent for each diagonal of distance.
  vtkSetMacro(UseFalloff, bool);
  vtkGetMacro(UseFalloff, bool);
  vtkBooleanMacro(UseFalloff, bool);
  vtkSetMacro(Falloff, double);
  vtkGetMacro(Falloff, double);

  /// Give each point its number in the file, the same in every mesh of it, as global ids ("vertex in file").
  vtkSetMacro(GiveFileIds, bool);
  vtkGetMacro(GiveFileIds, bool);
  vtkBooleanMacro(GiveFileIds, bool);

  /// Between these lies what the interface offers at first, in the middle: a box of half the domain's size, a sphere of
  /// half its smallest one. Lower and upper ends by axis; 0 to 1 before UpdateInformation().
  double* GetBoxPositionRange() VTK_SIZEHINT(6);
  double* GetBoxLengthRange() VTK_SIZEHINT(6);
  double* GetSphereCenterRange() VTK_SIZEHINT(6);
  double* GetSphereRadiusRange() VTK_SIZEHINT(2);

protected:
  vtkPtetReader();
  ~vtkPtetReader() override;

  int RequestInformation(vtkInformation* request, vtkInformationVector** inputs,
                         vtkInformationVector* outputs) override;
  int RequestData(vtkInformation* request, vtkInformationVector** inputs, vtkInformationVector* outputs) override;

private:
  char* FileName = nullptr;
  bool BoundFieldErrors = false;
  double FieldError = 1;
  bool BoundDomainError = false;
  double DomainError = 0.5;
  bool LimitTets = true;
  vtkIdType MaximumTets = 200000;
  int FocusShape = NO_FOCUS;
  double BoxPosition[3] = {0, 0, 0};
  double BoxRotation[3] = {0, 0, 0};
  double BoxLength[3] = {1, 1, 1};
  double SphereCenter[3] = {0, 0, 0};
  double SphereRadius = 1;
  double FocusError = 0;
  bool UseFalloff = false;
  double Falloff = 10;
  bool GiveFileIds = false;

  /// Runs `work()`; what it throws becomes an error event and the result 0.
  template <class Work>
  int Try(Work&& work);

  class Internals;
  std::unique_ptr<Internals> Internal;
};
// NOLINTEND(readability-identifier-naming)

#endif
