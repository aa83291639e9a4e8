# Installs the build into an empty folder, configures and builds the consumer against it, and runs what came out.
function(step)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "failed (${result}): ${command}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
set(prefix ${WORK_DIR}/prefix)
step(${CMAKE_COMMAND} --install ${PTET_BINARY_DIR} --prefix ${prefix})

set(options -DCMAKE_BUILD_TYPE=${BUILD_TYPE} -DCMAKE_CXX_COMPILER=${CXX_COMPILER} -DCMAKE_PREFIX_PATH=${prefix})
if(SANITIZE)
  list(APPEND options "-DCMAKE_CXX_FLAGS=-fsanitize=address,undefined")
endif()
step(${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${WORK_DIR}/consumer -G ${GENERATOR} ${options})
step(${CMAKE_COMMAND} --build ${WORK_DIR}/consumer)

step(${WORK_DIR}/consumer/write_file ${WORK_DIR}/block.ptet)
step(${WORK_DIR}/consumer/cut_file ${WORK_DIR}/block.ptet)
if(TOOLS)
  step(${prefix}/bin/ptet verify ${WORK_DIR}/block.ptet)
endif()

# A program that only reads must find the package where nothing of the builder's is to be found.
step(${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${WORK_DIR}/reader -G ${GENERATOR} ${options} -DREADER_ONLY=ON
     -DCMAKE_DISABLE_FIND_PACKAGE_CGAL=ON -DCMAKE_DISABLE_FIND_PACKAGE_OpenMesh=ON -DCMAKE_DISABLE_FIND_PACKAGE_TBB=ON)
step(${CMAKE_COMMAND} --build ${WORK_DIR}/reader)
step(${WORK_DIR}/reader/cut_file ${WORK_DIR}/block.ptet)
