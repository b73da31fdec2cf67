# cmake -D WEFT=PROGRAM -D OUT=FOLDER -D VERBS=... -D GZIP=PROGRAM -P texts.cmake: writes the manual
# pages, one for weft and one for each verb, packed where there is a gzip, and the completions.
cmake_minimum_required(VERSION 3.25)
function(weft_write file)
    execute_process(COMMAND ${WEFT} help ${ARGN} OUTPUT_FILE ${OUT}/${file}
        COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${OUT}/man1) # of verbs that there were
file(MAKE_DIRECTORY ${OUT}/man1)
weft_write(man1/weft.1 --man)
set(pages ${OUT}/man1/weft.1)
foreach(verb IN LISTS VERBS)
    weft_write(man1/weft-${verb}.1 --man ${verb})
    list(APPEND pages ${OUT}/man1/weft-${verb}.1)
endforeach()
if(GZIP)
    execute_process(COMMAND ${GZIP} -9nf ${pages} COMMAND_ERROR_IS_FATAL ANY)
endif()
weft_write(weft.bash --completion bash)
weft_write(_weft --completion zsh)
weft_write(weft.fish --completion fish)
file(TOUCH ${OUT}/stamp)
