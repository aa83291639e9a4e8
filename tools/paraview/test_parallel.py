"""On several processes the first has the whole mesh, the others nothing: mpiexec -n 2 pvbatch test_parallel.py PLUGIN FILE"""
import sys

from paraview import simple

simple.LoadPlugin(sys.argv[1], ns=globals())
reader = simple.OpenDataFile(sys.argv[2])
reader.LimitTetrahedra = 0
simple.UpdatePipeline(proxy=reader)
processes = simple.GetActiveSource().SMProxy.GetSession().GetNumberOfProcesses(1)
assert processes > 1, f"{processes} process"
marked = simple.ProcessIds(Input=reader) if hasattr(simple, "ProcessIds") else simple.ProcessIdScalars(Input=reader)
simple.UpdatePipeline(proxy=marked)
information = marked.GetDataInformation()
assert information.GetNumberOfCells() == 2869, information.GetNumberOfCells()
assert marked.PointData["PointProcessIds" if "PointProcessIds" in marked.PointData.keys() else "ProcessId"].GetRange() == (0, 0)
print(f"{processes} processes: one mesh of {information.GetNumberOfCells()} tets, in the first")
