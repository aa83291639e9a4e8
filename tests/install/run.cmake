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

set(options -DCMAKE_BUILD_TYPE=${BUILD_TYPE} -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_CXX_COMPILER=${CXX_COMPILER}
            -DCMAKE_PREFIX_PATH=${prefix})
if(SANITIZE)
  set(sanitize -fsanitize=address,undefined)
  list(APPEND options "-DCMAKE_C_FLAGS=${sanitize}" "-DCMAKE_CXX_FLAGS=${sanitize}")
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

# A program in C alone, through CMake.
step(${CMAKE_COMMAND} -S ${SOURCE_DIR}/tests/install/c_only -B ${WORK_DIR}/c_only -G ${GENERATOR} ${options})
step(${CMAKE_COMMAND} --build ${WORK_DIR}/c_only)
step(${WORK_DIR}/c_only/load_and_cut ${WORK_DIR}/block.ptet)

# The run-time library by itself, or as a part of another project, asks for nothing of the builder's.
set(without_builder -DCMAKE_DISABLE_FIND_PACKAGE_CGAL=ON -DCMAKE_DISABLE_FIND_PACKAGE_OpenMesh=ON
    -DCMAKE_DISABLE_FIND_PACKAGE_TBB=ON -DCMAKE_DISABLE_FIND_PACKAGE_VTK=ON -DCMAKE_DISABLE_FIND_PACKAGE_Catch2=ON)
step(${CMAKE_COMMAND} -S ${SOURCE_DIR} -B ${WORK_DIR}/run-time-only -G ${GENERATOR} ${options} -DPTET_BUILD_BUILDER=OFF
     ${without_builder})
step(${CMAKE_COMMAND} -S ${SOURCE_DIR}/tests/install/part -B ${WORK_DIR}/part -G ${GENERATOR} ${options}
     -DSOURCE_DIR=${SOURCE_DIR} ${without_builder})

# The examples, one of them in C, through CMake.
step(${CMAKE_COMMAND} -S ${SOURCE_DIR}/tools/examples -B ${WORK_DIR}/examples -G ${GENERATOR} ${options})
step(${CMAKE_COMMAND} --build ${WORK_DIR}/examples)
step(${WORK_DIR}/examples/example_load_and_cut ${WORK_DIR}/block.ptet)
step(${WORK_DIR}/examples/example_load_and_cut_c ${WORK_DIR}/block.ptet)
step(${WORK_DIR}/examples/example_build_in_memory)

# C programs through pkg-config and the C compiler alone, from where the tree was moved to.
file(RENAME ${prefix} ${WORK_DIR}/moved)
set(libraries ${WORK_DIR}/moved/${LIBDIR})
set(ENV{PKG_CONFIG_PATH} ${libraries}/pkgconfig:$ENV{PKG_CONFIG_PATH})
# compile(PACKAGE SOURCE PROGRAM OPTION...)
function(compile package source program)
  execute_process(COMMAND pkg-config --cflags --libs ${package} RESULT_VARIABLE result OUTPUT_VARIABLE flags
                  OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "pkg-config does not know ${package}")
  endif()
  separate_arguments(flags UNIX_COMMAND "${flags}")
  step(${C_COMPILER} -std=c11 -Wall -Wextra -Wpedantic -Werror ${sanitize} ${ARGN} ${source} -o ${program} ${flags} -lm
       -Wl,-rpath,${libraries})
endfunction()
compile(ptet ${SOURCE_DIR}/tools/examples/load_and_cut.c ${WORK_DIR}/load_and_cut)
step(${WORK_DIR}/load_and_cut ${WORK_DIR}/block.ptet)
compile(ptet-build ${SOURCE_DIR}/tests/c/c_interface_test.c ${WORK_DIR}/c_interface_test
        "-DPTET_TEST_VERSION=\"${VERSION}\"")
step(${WORK_DIR}/c_interface_test)
