# A card's settings and their page.
add_test(NAME Card.TheWiringIsDrawnAsItsSettingsAre COMMAND ${PROJECT_SOURCE_DIR}/device/card/draw_wiring --check)
add_test(NAME Card.MistakesAreToldByTheStatusWhereNoReportCanBeWritten
  COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/card_check.sh $<TARGET_FILE:ldp-card>)
