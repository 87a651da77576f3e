# A card's settings and their page.
add_test(NAME Card.TheWiringIsDrawnAsItsSettingsAre COMMAND ${PROJECT_SOURCE_DIR}/device/card/draw_wiring --check)
add_test(NAME Card.MistakesAreToldByTheStatusWhereNoReportCanBeWritten
  COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/card_check.sh $<TARGET_FILE:ldp-card>)
add_test(NAME Card.AnImageHoldsWhatItWasMadeOf
  COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/card_image.sh $<TARGET_FILE:ldp-card>)
set_tests_properties(Card.AnImageHoldsWhatItWasMadeOf PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 300)
find_program(SYSTEMD_ANALYZE systemd-analyze)
if(SYSTEMD_ANALYZE)
  add_test(NAME Card.ItsUnitsAreGoodAndExposedByLessThan2
    COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/card_units.sh ${SYSTEMD_ANALYZE})
endif()
add_test(NAME Card.AnUpdateIsTakenKeptAndGivenUp COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/card_update.sh)
