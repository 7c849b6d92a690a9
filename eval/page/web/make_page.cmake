# Makes page.html, the template of all HTML pages, with its style, script and the libraries from npm.
#   cmake -DNPM=... -DFROM=eval/page/web -DWORK=folder -DPAGE=file -P make_page.cmake
# Without npm or its registry there is no template: one line says so, and the build continues. The program
# then writes no pages, but all other results.

file(REMOVE ${PAGE})
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
foreach(file package.json package-lock.json .npmrc)
  file(COPY ${FROM}/${file} DESTINATION ${WORK})
endforeach()
if(NOT NPM)
  message("pickbed: the page template is not built, because there is no npm; install the packages of group report (packages.txt)")
  return()
endif()
execute_process(COMMAND ${NPM} ci --no-progress --loglevel=error
  WORKING_DIRECTORY ${WORK} RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(NOT status EQUAL 0)
  string(REGEX MATCH "[A-Z]+[^\n]*(ENOTFOUND|ECONNREFUSED|ETIMEDOUT|EAI_AGAIN|E40[0-9]|EUSAGE|EINTEGRITY)[^\n]*" reason "${said}")
  message("pickbed: the page template is not built, because `npm ci` failed (${reason}); build again when npm reaches its registry")
  return()
endif()

# read_library(NAME FILE): a library as a script element. "</script" inside a string would end the element.
function(read_library name file)
  file(READ ${WORK}/node_modules/${file} text)
  string(REGEX REPLACE "\n//# sourceMappingURL=[^\n]*" "" text "${text}")
  string(REPLACE "</script" "<\\/script" text "${text}")
  set(${name} "<script>\n${text}\n</script>\n" PARENT_SCOPE)
endfunction()
read_library(vega vega/build/vega.min.js)
read_library(vega_lite vega-lite/build/vega-lite.min.js)
read_library(vega_embed vega-embed/build/vega-embed.min.js)
read_library(model_viewer @google/model-viewer/dist/model-viewer-umd.min.js)

file(READ ${FROM}/page.html page)
file(READ ${FROM}/page.css style)
file(READ ${FROM}/page.js script)
string(REPLACE "@PICKBED_STYLE@" "${style}" page "${page}")
string(REPLACE "@PICKBED_SCRIPT@" "${script}" page "${page}")
# The program removes the parts between these marks from a page without charts or without 3D views.
string(REPLACE "@PICKBED_CHARTS_LIBRARY@" "<!--charts-->\n${vega}${vega_lite}${vega_embed}<!--/charts-->" page "${page}")
string(REPLACE "@PICKBED_VIEWS_LIBRARY@" "<!--views-->\n${model_viewer}<!--/views-->" page "${page}")
file(WRITE ${PAGE} "${page}")
file(REMOVE_RECURSE ${WORK})
